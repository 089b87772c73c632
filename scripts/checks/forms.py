"""Closed forms and double-precision integrals that the checks expect. None of this knows Kiln's code."""
from math import acos, atan2, cos, exp, pi, radians, sin, sqrt


def glowing_box(emission, albedo, depth):
    """Radiance in a closed box after at most `depth` scatterings: emission · Σ albedo^k, k = 0 … depth."""
    return emission * sum(albedo**k for k in range(depth + 1))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def irradiance(triangles, point, normal, radiance=1.0):
    """Irradiance from unoccluded one-sided triangles of uniform radiance: Lambert's contour integral
    E = L/2 · Σ angle(v_i, v_i+1) · (unit(v_i × v_i+1) · n), after cutting each at the point's horizon."""
    total = 0.0
    for triangle in triangles:
        corners = [minus(c, point) for c in triangle]
        if dot(cross(minus(corners[1], corners[0]), minus(corners[2], corners[0])), corners[0]) >= 0:
            continue  # the point is behind it, or in its plane
        above = []
        for a, b in zip(corners, corners[1:] + corners[:1]):
            ha, hb = dot(a, normal), dot(b, normal)
            if ha > 0:
                above.append(a)
            if (ha > 0) != (hb > 0):
                above.append(tuple(x + (y - x) * ha / (ha - hb) for x, y in zip(a, b)))
        contour = 0.0
        for a, b in zip(above, above[1:] + above[:1]):
            n = cross(a, b)
            length = sqrt(dot(n, n))
            if length > 0:
                contour += atan2(length, dot(a, b)) * dot(n, normal) / length
        total += abs(contour) / 2
    return total * radiance


def solid_angle(triangle, point):
    """Of a triangle as seen from a point (Van Oosterom & Strackee 1983)."""
    unit = []
    for corner in triangle:
        v = minus(corner, point)
        unit.append(tuple(x / sqrt(dot(v, v)) for x in v))
    a, b, c = unit
    return 2 * atan2(abs(dot(a, cross(b, c))), 1 + dot(a, b) + dot(b, c) + dot(c, a))


def ggx_furnace(alpha, degrees, f0, nodes=500):
    """What single-scattering GGX with height-correlated Smith masking and Schlick's Fresnel reflects of a white world,
    (1/cos θo) ∫ F(o·h) D(h) G2(o, i) (o·h) dh over the normals whose mirror direction i is above the surface, by the
    midpoint rule in t with tan² θh = α² t/(1 − t), for which D cos θh dh = dt dφ / 2π; nodes crowd at t = 1, where grazing
    views have their horizon. 500 nodes are right to 1e-5."""
    ox, oz = sin(radians(degrees)), cos(radians(degrees))
    stretched = lambda cosine: sqrt(cosine**2 + alpha**2 * (1 - cosine**2))
    cosines = [cos((k + 0.5) * pi / nodes) for k in range(nodes)]  # the other half of the azimuths is the mirror image
    total = 0.0
    for k in range(nodes):
        left = 1 - (k + 0.5) / nodes
        t, share = 1 - left**3, 3 * left**2
        tan2 = alpha**2 * t / left**3
        hz = 1 / sqrt(1 + tan2)
        sine = sqrt(tan2) * hz
        for cosine in cosines:
            oh = ox * sine * cosine + oz * hz
            iz = min(2 * oh * hz - oz, 1.0)
            if oh > 0 and iz > 0:
                g2 = 2 * oz * iz / (oz * stretched(iz) + iz * stretched(oz))
                total += share * (f0 + (1 - f0) * (1 - oh) ** 5) * g2 * oh / (oz * hz)
    return total / nodes**2


def compensated_furnace(alpha, degrees, f0):
    """As ggx_furnace, times what multiple scattering adds: 1 + F Ē/(1 − F(1 − Ē)) · (1 − E)/E with E the albedo of a white
    surface at this angle, Ē its mean over the cosine (32 midpoints over cos²), F = (albedo with F0)/E (Turquin 2019)."""
    white, coloured = ggx_furnace(alpha, degrees, 1.0), ggx_furnace(alpha, degrees, f0)
    angles = [acos(sqrt((k + 0.5) / 32)) * 180 / pi for k in range(32)]
    mean = sum(ggx_furnace(alpha, angle, 1.0, 120) for angle in angles) / 32
    f = coloured / white
    return coloured * (1 + f * mean / (1 - f * (1 - mean)) * (1 - white) / white)


def slab(reflectance, transmittance):
    """Reflected and transmitted together by a plate in a white world: R + T²a/(1 − Ra), T = 1 − R."""
    r, a = reflectance, transmittance
    return r + (1 - r) ** 2 * a / (1 - r * a)


def layers(indices, transmittances):
    """Reflected and transmitted together, in a white world, by parallel plates that touch, at normal incidence and without
    interference: `indices` from the medium before to the one behind, `transmittances` of the plates between. Plates are
    added one by one: R = R1 + T1² R2 / (1 − R1' R2) and so on (Stokes 1862)."""
    fresnel = lambda a, b: ((a - b) / (a + b)) ** 2
    front, back, through = 0.0, 0.0, 1.0  # reflectances from before and behind, transmittance of what is there so far
    for k, (a, b) in enumerate(zip(indices, indices[1:])):
        r = fresnel(a, b)
        bounces = 1 / (1 - back * r)
        front, back, through = (front + through**2 * r * bounces, r + (1 - r) ** 2 * back * bounces, through * (1 - r) * bounces)
        if k < len(transmittances):
            back, through = back * transmittances[k] ** 2, through * transmittances[k]
    return front + through


def disc_beyond(distance, radius):
    """Share of a disc's area beyond a line at `distance` from its centre."""
    h = distance / radius
    return (acos(h) - h * sqrt(1 - h * h)) / pi


def clamped(constant, linear, quadratic, d):
    return min(1.0, 1.0 / (constant + linear * d + quadratic * d * d))


def linear_of_srgb(byte):
    c = byte / 255
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


def spectrum(step=0.5):
    """Wavelengths (nm) with their shares in linear sRGB, which add up to 1 in each channel: the CIE 1931 functions in the fit of
    Wyman, Sloan & Shirley 2013, out-of-gamut parts cut off, from 380 to 720 nm."""
    bell = lambda nm, mean, below, above: exp(-0.5 * ((nm - mean) * (below if nm < mean else above)) ** 2)
    matrix = ((3.2406, -1.5372, -0.4986), (-0.9689, 1.8758, 0.0415), (0.0557, -0.2040, 1.0570))
    rows = []
    for k in range(round(340 / step)):
        nm = 380 + (k + 0.5) * step
        xyz = (0.362 * bell(nm, 442, 0.0624, 0.0374) + 1.056 * bell(nm, 599.8, 0.0264, 0.0323) - 0.065 * bell(nm, 501.1, 0.0490, 0.0382),
               0.821 * bell(nm, 568.8, 0.0213, 0.0247) + 0.286 * bell(nm, 530.9, 0.0613, 0.0322),
               1.217 * bell(nm, 437, 0.0845, 0.0278) + 0.681 * bell(nm, 459, 0.0385, 0.0725))
        rows.append((nm, [max(0, sum(m * x for m, x in zip(row, xyz))) for row in matrix]))
    totals = [sum(rgb[c] for _, rgb in rows) for c in range(3)]
    return [(nm, [x / t for x, t in zip(rgb, totals)]) for nm, rgb in rows]


def cauchy(index, dispersion, nm):
    """Index of refraction at a wavelength (KHR_materials_dispersion; index: that of the d line)."""
    return max(1, index + (index - 1) * dispersion / 20 * (523655 / nm**2 - 1.5168))


def reflectance(degrees, eta):
    """Fresnel's, unpolarised, for light that meets a medium of relative index eta."""
    cos_i = cos(radians(degrees))
    cos2_t = 1 - (1 - cos_i**2) / eta**2
    if cos2_t <= 0:
        return 1.0
    cos_t = sqrt(cos2_t)
    parallel, perpendicular = (eta * cos_i - cos_t) / (eta * cos_i + cos_t), (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    return (parallel**2 + perpendicular**2) / 2


def dispersing_prism(degrees, index, dispersion):
    """In a white world: what is reflected at normal incidence, and what goes through the second face, met at `degrees`."""
    seen = [0.0, 0.0, 0.0]
    for nm, shares in spectrum():
        n = cauchy(index, dispersion, nm)
        first, second = reflectance(0, n), reflectance(degrees, 1 / n)
        seen = [s + share * (first + (1 - first) * (1 - second)) for s, share in zip(seen, shares)]
    return seen
