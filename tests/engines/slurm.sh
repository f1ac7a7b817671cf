#!/bin/bash
# Tries a sweep on a Slurm of this machine alone: 200 tasks, one killed, one requeued; long tasks driven out by others,
# with and without a time of grace, ended by their time limit, cancelled; then how many scenes a second it does beside a
# plain sweep. As root, with Debian's slurm-wlm, which it installs where it can.
# Usage: tests/engines/slurm.sh [PROGRAM [TRIAL...]]; trials, by default each once in this order:
all=(killed_and_requeued driven_out_without_grace driven_out_with_grace ended_by_their_time_limit cancelled throughput)
set -u
PROGRAM=$(readlink -f "${1:-target/release/tyrewave}")
source "$(dirname "$0")/common.sh"
trials=("${@:2}")
[ ${#trials[@]} -gt 0 ] || trials=("${all[@]}")
[ -x "$PROGRAM" ] || skip "there is no $PROGRAM"
[ "$(id -u)" = 0 ] || skip "a Slurm of one's own needs root"
if ! command -v slurmctld > /dev/null; then
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends slurm-wlm munge > /dev/null 2>&1
    command -v slurmctld > /dev/null || skip "Slurm is not installed, and apt-get has no slurm-wlm for it"
fi
WORK=$(mktemp -d /tmp/tyrewave-slurm.XXXXXX)
export TYREWAVE_CACHE_DIR=$WORK/cache SLURM_CONF=$WORK/slurm.conf
chmod 755 "$WORK"
daemons=()
trap 'kill "${daemons[@]}" 2> /dev/null; wait 2> /dev/null; rm -rf "$WORK"' EXIT

# Sockets, keys, states and logs of its own: nothing of the system's is used or changed.
mkdir -p "$WORK"/{state,spool}
head -c 64 /dev/urandom > "$WORK/munge.key" && chmod 400 "$WORK/munge.key"
munged --foreground --force --key-file "$WORK/munge.key" --socket "$WORK/munge.socket" --pid-file "$WORK/munge.pid" \
    --log-file "$WORK/munge.log" --seed-file "$WORK/munge.seed" > /dev/null 2>&1 &
daemons+=($!)
cat > "$SLURM_CONF" <<END
ClusterName=trial
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$WORK/munge.socket
SlurmctldPort=26817
SlurmdPort=26818
SlurmctldPidFile=$WORK/slurmctld.pid
SlurmdPidFile=$WORK/slurmd.pid
SlurmctldLogFile=$WORK/slurmctld.log
SlurmdLogFile=$WORK/slurmd.log
StateSaveLocation=$WORK/state
SlurmdSpoolDir=$WORK/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerParameters=sched_interval=1,sched_min_interval=0,batch_sched_delay=0
ReturnToService=2
KillWait=10
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=2000 State=UNKNOWN
PartitionName=low Nodes=ALL Default=YES PriorityTier=1 PreemptMode=REQUEUE GraceTime=0 State=UP
PartitionName=high Nodes=ALL PriorityTier=2 PreemptMode=OFF State=UP
END
sleep 1
slurmctld -D -c > "$WORK/ctld.out" 2>&1 &
daemons+=($!)
slurmd -D > "$WORK/slurmd.out" 2>&1 &
daemons+=($!)
for _ in $(seq 60); do sinfo -h -o %T 2> /dev/null | grep -q idle && break; sleep 0.5; done
sinfo -h -o %T 2> /dev/null | grep -q idle || { tail -5 "$WORK"/*.log "$WORK"/*.out; skip "Slurm does not start here"; }
echo "$(sinfo --version), $(nproc) processors; $("$PROGRAM" --version)"

until_idle() { while [ -n "$(squeue -h)" ]; do sleep "${1:-0.5}"; ${2:-true}; done; }
# Slurm lets an element that was put back into the queue wait for two minutes. It may be hastened, but not at once: the
# credential of its next start must be younger, in whole seconds, than the end of the last one, or the node refuses it
# ("Job credential revoked") and the element is lost. An element is named by array and number: the array's own number,
# which its last element has, stands for all of them.
at_once() {
    local element queued
    while read -r element queued; do
        [[ $element = *[* ]] || [ $(($(date +%s) - $(date -d "$queued" +%s))) -lt 3 ] ||
            scontrol update JobId="$element" StartTime=now 2> /dev/null
    done < <(squeue -h -t PD -o "%i %V")
}

killed_and_requeued() {
    begin=$(now)
    "$PROGRAM" sweep "${trial[@]}" --out "$WORK/plain" --quiet > /dev/null || fail "the plain sweep"
    echo "plain sweep of 200 scenes: $(since "$begin") s"
    "$PROGRAM" sweep "${trial[@]}" --tasks "$tasks" --chunk 1 --quiet || fail "writing tasks"
    begin=$(now)
    job=$(sbatch --parsable "$tasks/job.slurm") || fail "sbatch"
    until_done "$tasks" 20
    kill_one "$tasks"
    until_done "$tasks" 60
    hold_one "$tasks"
    scontrol requeue "${job}_$number" || fail "requeue"
    kill -CONT "$pid"
    echo "requeued task $number"
    sleep 4
    at_once
    until_idle
    "$PROGRAM" sweep --collect "$tasks" --quiet > /dev/null 2> "$WORK/told" && fail "the killed task is not missing"
    cat "$WORK/told"
    job=$(sbatch --parsable --array="$(cat "$tasks/missing")" "$tasks/job.slurm") || fail "sbatch of what is missing"
    until_idle
    echo "200 tasks with all that: $(since "$begin") s"
    cat "$tasks"/logs/*.txt > "$WORK/log"
    check "$tasks" "$WORK/log"
}

# Two long tasks that are ended before they are done, and come back by themselves; but not where they are cancelled.
long=("${scene[@]}" --set "rolling.duration=${LONG:-4000.0}" --speed 60,80)
long_tasks() {
    if ! [ -e "$WORK/long-plain" ]; then
        begin=$(now)
        "$PROGRAM" sweep "${long[@]}" --out "$WORK/long-plain" --quiet > /dev/null || fail "the plain sweep of long scenes"
        echo "plain sweep of two long scenes: $(since "$begin") s"
    fi
    "$PROGRAM" sweep "${long[@]}" --tasks "$tasks" --chunk 1 --quiet || fail "writing long tasks"
    job=$(sbatch --parsable "$@" "$tasks/job.slurm") || fail "sbatch of long tasks"
}
went_on() {
    until_idle 1 at_once
    grep -ahE 'continues at|back into' "$tasks"/logs/*.txt | sed 's/^/  /'
    "$PROGRAM" sweep --collect "$tasks" --quiet > /dev/null || fail "long tasks are missing"
    cmp "$tasks/sweep.csv" "$WORK/long-plain/sweep.csv" || fail "the table is not that of the plain sweep"
    for number in 0 1; do
        grep -q "task $number .*continues at" "$tasks"/logs/*.txt || fail "task $number did not go on"
    done
}
drive_out() {
    sleep 3
    sbatch --quiet --partition=high --cpus-per-task="$(nproc)" --mem=100M --output=/dev/null --wrap "sleep 3"
}
driven_out_without_grace() { long_tasks; drive_out; went_on; }
driven_out_with_grace() {
    scontrol update PartitionName=low GraceTime=5
    driven_out_without_grace
    scontrol update PartitionName=low GraceTime=0
}
ended_by_their_time_limit() {
    # Slurm looks every 30 s, and tells up to 30 s early: after 5 to 35 s here, which LONG must outlast.
    long_tasks --time=1 --signal=B:TERM@25
    went_on
}
cancelled() {
    long_tasks
    sleep 5
    scancel "$job"
    until_idle
    "$PROGRAM" sweep --collect "$tasks" --quiet > /dev/null 2>&1 && fail "cancelled tasks came back"
    job=$(sbatch --parsable --array="$(cat "$tasks/missing")" "$tasks/job.slurm") || fail "sbatch of what is missing"
    went_on
}
by_engine() { sbatch --quiet "$1/job.slurm" && until_idle 0.1; }
run_of=0
for name in "${trials[@]}"; do
    run_of=$((run_of + 1))
    tasks=$WORK/$name-$run_of
    echo "$name:"
    case "$name" in
        throughput) throughput Slurm "${CHUNK:-250}" ;;
        *) [[ " ${all[*]} " = *" $name "* ]] || fail "$name is none of the trials"; "$name" ;;
    esac
done
