// Embree's side of the ray race (examples/bench_rays.rs): one thread, single-ray queries, answers over standard output.
//   c++ -O3 -march=native scripts/bench/embree_rays.cpp -o embree_rays -lembree3 -pthread     (Debian: apt-get install libembree-dev)
// embree_rays MESH.bin [robust] [PLACEMENTS.bin]: builds three times with two threads and prints the best wall and the mean CPU seconds; then reads commands:
//   With placements (each 12 floats, three columns and the origin), the scene is instances of the mesh.
//   closest FILE | any FILE   loads rays (u32 n, then n * (ox oy oz tnear dx dy dz tfar))
//   pass N                    traces them on N threads and prints CPU seconds of all, hits, the sum of the hits' distances
//   quit
#include <embree3/rtcore.h>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>
#include <time.h>
#include <vector>

// CPU seconds of this thread: others may be busy on the machine.
static double cpu() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return t.tv_sec + t.tv_nsec * 1e-9;
}
static double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

struct Share {
    double seconds = 0;
    uint64_t hits = 0;
    double sum = 0;
};

struct InputRay {
    float origin[3], tnear, dir[3], tfar;
};

static void set(RTCRay& ray, const InputRay& in) {
    ray.org_x = in.origin[0], ray.org_y = in.origin[1], ray.org_z = in.origin[2], ray.tnear = in.tnear;
    ray.dir_x = in.dir[0], ray.dir_y = in.dir[1], ray.dir_z = in.dir[2], ray.tfar = in.tfar;
    ray.time = 0, ray.mask = ~0u, ray.id = 0, ray.flags = 0;
}

int main(int argc, char** argv) {
    if (argc < 2) return 2;
    bool robust = argc > 2 && !strcmp(argv[2], "robust");
    std::vector<float> placements;
    if (argc > 2 + robust) {
        std::ifstream in(argv[2 + robust], std::ios::binary | std::ios::ate);
        placements.resize(in.tellg() / 4);
        in.seekg(0).read(reinterpret_cast<char*>(placements.data()), placements.size() * 4);
    }
    std::ifstream file(argv[1], std::ios::binary);
    uint32_t counts[2];
    if (!file.read(reinterpret_cast<char*>(counts), 8)) return 1;
    std::vector<float> points(counts[0] * 3 + 4);
    std::vector<uint32_t> faces(counts[1] * 3);
    file.read(reinterpret_cast<char*>(points.data()), counts[0] * 12);
    file.read(reinterpret_cast<char*>(faces.data()), counts[1] * 12);

    RTCDevice device = rtcNewDevice("threads=2,set_affinity=0");
    double best = 1e30, process = clock() / double(CLOCKS_PER_SEC);
    RTCScene scene = nullptr;
    for (int k = 0; k < 3; k++) {
        if (scene) rtcReleaseScene(scene);
        scene = rtcNewScene(device);
        RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, points.data(), 0, 12, counts[0]);
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, faces.data(), 0, 12, counts[1]);
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(scene, mesh);
        rtcReleaseGeometry(mesh);
        if (robust) rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        double begin = now();
        rtcCommitScene(scene);
        if (!placements.empty()) {
            RTCScene all = rtcNewScene(device);
            if (robust) rtcSetSceneFlags(all, RTC_SCENE_FLAG_ROBUST);
            for (size_t i = 0; i < placements.size(); i += 12) {
                RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
                rtcSetGeometryInstancedScene(instance, scene);
                rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &placements[i]);
                rtcCommitGeometry(instance);
                rtcAttachGeometry(all, instance);
                rtcReleaseGeometry(instance);
            }
            rtcCommitScene(all);
            rtcReleaseScene(scene);
            scene = all;
        }
        best = std::min(best, now() - begin);
    }
    process = (clock() / double(CLOCKS_PER_SEC) - process) / 3;
    std::cout << best << " " << process << std::endl;

    std::vector<InputRay> rays;
    bool any = false;
    std::string command;
    while (std::cin >> command && command != "quit") {
        if (command == "pass") {
            size_t threads = 1;
            std::cin >> threads;
            std::vector<Share> shares(threads);
            auto trace = [&](size_t k) {
                uint64_t hits = 0;
                double sum = 0, begin = cpu();
                for (size_t i = rays.size() * k / threads; i < rays.size() * (k + 1) / threads; i++) {
                    const InputRay& in = rays[i];
                    RTCIntersectContext context;
                    rtcInitIntersectContext(&context);
                    if (any) {
                        RTCRay ray;
                        set(ray, in);
                        rtcOccluded1(scene, &context, &ray);
                        hits += ray.tfar < 0;
                    } else {
                        RTCRayHit hit;
                        set(hit.ray, in);
                        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                        rtcIntersect1(scene, &context, &hit);
                        if (hit.hit.geomID != RTC_INVALID_GEOMETRY_ID) hits++, sum += hit.ray.tfar;
                    }
                }
                shares[k] = {cpu() - begin, hits, sum};
            };
            std::vector<std::thread> others;
            for (size_t k = 1; k < threads; k++) others.emplace_back(trace, k);
            trace(0);
            for (std::thread& other : others) other.join();
            Share all;
            for (const Share& share : shares) all.seconds += share.seconds, all.hits += share.hits, all.sum += share.sum;
            std::printf("%.9f %llu %.9g\n", all.seconds, (unsigned long long)all.hits, all.sum);
            std::fflush(stdout);
        } else {
            std::string path;
            std::cin >> path;
            any = command == "any";
            std::ifstream in(path, std::ios::binary);
            uint32_t n = 0;
            in.read(reinterpret_cast<char*>(&n), 4);
            rays.resize(n);
            in.read(reinterpret_cast<char*>(rays.data()), n * sizeof(InputRay));
            std::cout << n << std::endl;
        }
    }
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}
