#!/usr/bin/env bash
# A real Slurm of two nodes on this machine runs scripts/farm/slurm.sbatch over a folder; one node is killed in the middle, its
# task comes back, the shards are merged: every picture is there once, byte for byte as one machine makes it.
#   tests/farm/slurm.sh KILN        (as root, with Debian's slurm-wlm and munge)
set -euo pipefail
here="$(cd "$(dirname "$0")/../.." && pwd)"
kiln="$(realpath "$1")"
top="$(mktemp -d)"
processes=()
ended() {
    local code=$?
    if [ $code != 0 ]; then tail -n 40 "$top"/*.log "$top"/*.out >&2 2>/dev/null || true; fi
    # What was started here, by its number: daemons, and the steps of the nodes.
    local id parent
    for id in $(steps); do
        parent=$(sed -n 's/^PPid:\t//p' "/proc/$id/status" 2>/dev/null || true)
        if [ "$(cat "/proc/$parent/comm" 2>/dev/null || true)" = slurmstepd ]; then kill -9 "$parent" 2>/dev/null || true; fi
    done
    for id in "${processes[@]}" $(steps); do kill -9 "$id" 2>/dev/null || true; done
    rm -rf "$top"
    exit $code
}
# The processes of jobs that were begun by this Slurm.
steps() { for pid in /proc/[0-9]*; do
    if tr '\0' '\n' 2>/dev/null <"$pid/environ" | grep -qx "KILN_FARM=$top"; then basename "$pid"; fi
done; }
trap ended EXIT
fail() { echo "slurm: $*" >&2; exit 1; }
# wait_for SECONDS WHAT COMMAND...: until the command succeeds.
wait_for() {
    local end=$((SECONDS + $1)) what=$2
    shift 2
    until "$@" >/dev/null 2>&1; do
        [ $SECONDS -lt $end ] || fail "waited in vain for $what"
        sleep 0.2
    done
}

# Authentication of its own, beside whatever the machine runs.
mkdir -p "$top/munge" "$top/state" "$top/n0" "$top/n1"
chmod 755 "$top"
head -c 1024 /dev/urandom >"$top/munge/key"
chown -R munge:munge "$top/munge"
chmod 700 "$top/munge" && chmod 400 "$top/munge/key"
mkdir "$top/socket" && chown munge:munge "$top/socket" && chmod 755 "$top/socket"
setpriv --reuid munge --regid munge --clear-groups munged --foreground --key-file "$top/munge/key" --socket "$top/socket/munge" \
    --pid-file "$top/munge/pid" --seed-file "$top/munge/seed" --log-file "$top/munge/log" &
processes+=($!)
wait_for 10 munged munge -S "$top/socket/munge" -n

base=$((20000 + RANDOM % 10000))
cat >"$top/slurm.conf" <<CONF
ClusterName=kiln
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=$base
AuthType=auth/munge
AuthInfo=socket=$top/socket/munge
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$top/state
SlurmctldPidFile=$top/slurmctld.pid
SlurmdPidFile=$top/%n/slurmd.pid
SlurmdSpoolDir=$top/%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
ReturnToService=2
SlurmdTimeout=5
SchedulerParameters=batch_sched_delay=0,sched_interval=1
PriorityType=priority/basic
NodeName=n0 NodeAddr=127.0.0.1 NodeHostname=$(hostname -s) Port=$((base + 1)) CPUs=1
NodeName=n1 NodeAddr=127.0.0.1 NodeHostname=$(hostname -s) Port=$((base + 2)) CPUs=1
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF="$top/slurm.conf"
slurmctld -D -i >"$top/slurmctld.log" 2>&1 &
processes+=($!)
wait_for 20 slurmctld scontrol ping
declare -A node
for name in n0 n1; do
    slurmd -D -N "$name" >"$top/slurmd-$name.log" 2>&1 &
    node[$name]=$!
    processes+=($!)
done
wait_for 30 "both nodes" bash -c '[ "$(sinfo -h -N -t idle -o %N | sort -u | wc -l)" = 2 ]'

# The assets, and what one machine makes of them.
mkdir -p "$top/in"
for i in $(seq -w 1 40); do
    printf 'v -0.5 0 0\nv 0.%s 0 0\nv 0.5 1 0\nv -0.5 1 0\nv 0 0 1\nf 1 2 3 4\nf 1 2 5\n' "$((10#$i + 50))" >"$top/in/$i.obj"
done
options=(--width 32 --spp "${SPP:-800}" --format png --quiet)
"$kiln" batch "$top/in" --out "$top/alone" "${options[@]}"

# A Slurm array, one task a shard.
export KILN="$kiln" KILN_FARM="$top"
job=$(cd "$top" && sbatch --parsable --array=1-4 --cpus-per-task=1 --mem=0 -o "$top/task-%a.out" \
    "$here/scripts/farm/slurm.sbatch" "$top/in" "$top/out" "${options[@]}" --jobs 1)
two_on_n0() { [ -n "$(squeue -h -j "$job" -w n0 -t R -o %A)" ] && ls "$top"/out/shard-*/*.png; }
wait_for 30 "pictures of a task on n0" two_on_n0
lost=$(squeue -h -j "$job" -w n0 -t R -o %A)
[ -n "$lost" ] || fail "no task runs on n0"
# The node dies with all that runs on it, at once.
kill -9 "${node[n0]}"
# The one that would tell the master first.
for pid in $(pgrep -f "^slurmstepd: \[$lost\.batch\]" || true); do kill -9 "$pid" || true; done
for pid in $(steps); do
    if tr '\0' '\n' <"/proc/$pid/environ" 2>/dev/null | grep -qx "SLURM_JOB_ID=$lost"; then kill -9 "$pid" 2>/dev/null || true; fi
done
scontrol update nodename=n0 state=down reason=killed
echo "slurm: killed n0 with task $lost after $(find "$top/out" -name '*.png' | wc -l) of 40 pictures"
[ "$(find "$top/out" -name '*.png' | wc -l)" -lt 40 ] || fail "it was too late to kill a node"
# The task waits for another node; nobody waits for the delay that Slurm gives it.
wait_for 30 "the task in the queue again" bash -c "[ \"\$(squeue -h -j $lost -t PD -o %A)\" = $lost ]"
finished() {
    scontrol update jobid="$lost" starttime=now || true
    [ -z "$(squeue -h -j "$job" -o %A)" ]
}
wait_for 120 "the array" finished

"$kiln" merge "$top"/out/shard-* --out "$top/merged" || fail "merge ended with $?"
"$kiln" batch "$top/in" --out "$top/merged" "${options[@]}" --dry-run | grep -c '^up to date' | grep -qx 40 || fail "the merged folder is not up to date"
count=$(find "$top"/out/shard-* -name '*.png' | wc -l)
[ "$count" = 40 ] || fail "$count pictures in the shards instead of 40"
for picture in "$top"/alone/*.png; do
    cmp "$picture" "$top/merged/$(basename "$picture")" || fail "$(basename "$picture") differs"
done
[ "$(wc -l <"$top/merged/manifest.jsonl")" = 40 ] || fail "the manifest has not 40 lines"
echo "slurm: 40 pictures, each once, byte for byte as on one machine"
