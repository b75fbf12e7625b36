#!/usr/bin/env bash
# Renders by a real Slurm, of one node, and compares with one machine bit for bit.
#
#     scripts/slurm-test.sh [GEMTRACE]
#
# Needs Debian 12 or a relative of it, and root: the daemons come from the distribution's packages. They run on ports and
# in a folder of their own and are gone in the end; a Slurm that is already here is not touched. GEMTRACE is the program
# to test [target/release/gemtrace, built if it is not there].
#
# A sweep is rendered by an array of eight tasks, two of which are killed in the middle of their work and requeued; and
# one picture by an array of eight. Both are merged, and must be what one machine makes without Slurm.
set -euo pipefail
cd "$(dirname "$0")/.."

say() { echo "slurm-test: $*"; }
fail() { say "FAILED: $*" >&2; exit 1; }

[ "$(id -u)" = 0 ] || fail "this needs root, for Slurm's daemons"
has() { command -v "$1" >/dev/null; }
if ! { has slurmctld && has slurmd && has sbatch && has munged; }; then
  say "installing Slurm"
  apt-get update -q >/dev/null
  DEBIAN_FRONTEND=noninteractive apt-get install -y -q slurmctld slurmd slurm-client munge >/dev/null
fi
gemtrace=${1:-${CARGO_TARGET_DIR:-target}/release/gemtrace}
[ -x "$gemtrace" ] || cargo build --release --package gemtrace-cli
work=$(mktemp -d /tmp/slurm-test.XXXXXX)
mkdir "$work"/{bin,munge,state,spool,log}
chmod 755 "$work"
ln -s "$(realpath "$gemtrace")" "$work/bin/gemtrace"
export PATH="$work/bin:$PATH" SLURM_CONF="$work/slurm.conf"
unset "${!SLURM_ARRAY@}" JOB_COMPLETION_INDEX

daemons=()
cleanup() {
  status=$?
  if [ "$status" != 0 ]; then
    tail -n 20 "$work"/log/* "$work"/*.log 2>/dev/null || true
  fi
  # The daemons that were started here, by their own process numbers.
  [ "${#daemons[@]}" = 0 ] || kill "${daemons[@]}" 2>/dev/null || true
  wait 2>/dev/null || true
  rm -rf "$work"
}
trap cleanup EXIT

# ---- a cluster of one ------------------------------------------------------------------------------------------------

dd if=/dev/urandom of="$work/munge/key" bs=1024 count=1 status=none
chmod 700 "$work/munge"
chmod 400 "$work/munge/key"
munged --foreground --force --key-file="$work/munge/key" --socket="$work/munge/socket" --pid-file="$work/munge/pid" \
  --log-file="$work/log/munged.log" --seed-file="$work/munge/seed" >"$work/log/munged.out" 2>&1 &
daemons+=($!)

host=$(hostname -s)
cat >"$SLURM_CONF" <<CONF
ClusterName=gemtrace
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=26817
SlurmdPort=26818
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
CredType=cred/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/log/slurmctld.log
SlurmdLogFile=$work/log/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_interval=1,requeue_delay=1
SlurmdParameters=config_overrides
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=4 State=UNKNOWN
PartitionName=main Nodes=$host Default=YES State=UP
CONF

# Tries a command until it succeeds, for a minute.
await() {
  for _ in $(seq 240); do
    if "$@" >/dev/null 2>&1; then return 0; fi
    sleep 0.25
  done
  fail "waited in vain for: $*"
}

await test -S "$work/munge/socket"
slurmctld -D >"$work/log/slurmctld.out" 2>&1 &
daemons+=($!)
await scontrol ping
slurmd -D -N "$host" >"$work/log/slurmd.out" 2>&1 &
daemons+=($!)
up() { sinfo --noheader --format=%T | grep -qx idle; }
await up
say "$(sinfo --version) is up"

# ---- a sweep ---------------------------------------------------------------------------------------------------------

cp -r docs/cluster scenes "$work"
cd "$work"
options=(--backend cpu --size 64x64 --samples 25)
gemtrace batch scenes/sweeps/catalogue.toml --output one "${options[@]}" --quiet
say "one machine has rendered $(find one -name '*.png' | wc -l) pictures"

submit() { sbatch --parsable "$@"; }
over() { [ -z "$(squeue --noheader --jobs="$1" 2>/dev/null)" ]; }
finish() {
  for _ in $(seq 1200); do
    if over "$1"; then return 0; fi
    sleep 0.25
  done
  fail "job $1 does not come to an end"
}
state() { scontrol show job "$1" | grep -o 'JobState=[A-Z]*' | cut -d= -f2; }
is() { [ "$(state "$1")" = "$2" ]; }
lines() { grep -c '"status":"done"' "many/manifest-$1-of-8.jsonl" 2>/dev/null || true; }

job=$(submit cluster/array.sbatch scenes/sweeps/catalogue.toml many "${options[@]}")
for task in 2 5; do
  for _ in $(seq 2400); do
    [ "$(lines "$task")" -ge 3 ] 2>/dev/null && break
    sleep 0.02
  done
  scancel --batch --signal=KILL "${job}_$task"
  await is "${job}_$task" FAILED
  say "task $task was killed with $(lines "$task") of 25 pictures done"
  [ "$(lines "$task")" -lt 25 ] || fail "task $task was over before it was killed"
done
if gemtrace merge many >/dev/null 2>"$work/incomplete"; then fail "what was killed was not missed"; fi
grep -q "items are missing" "$work/incomplete" || fail "$(cat "$work/incomplete")"
for task in 2 5; do scontrol requeue "${job}_$task"; done
finish "$job"
for task in 1 2 3 4 5 6 7 8; do
  is "${job}_$task" COMPLETED || fail "task $task is $(state "${job}_$task")"
done

gemtrace merge many
compare() { diff --recursive --brief --exclude='manifest*' --exclude=index.html one many; }
compare || fail "the pictures differ"
timeless() { grep '"status":"done"' "$1/manifest.jsonl" | sed -E 's/"seconds":\{[^}]*\},?//'; }
diff <(timeless one) <(timeless many) >/dev/null || fail "the manifests differ"
begun=$(cat many/manifest-*-of-8.jsonl | grep -c '"status":"started"')
[ "$begun" -le 202 ] || fail "$begun pictures were begun, of 200 with two in flight when they were killed"
say "eight tasks, two of them killed and requeued, made the same 200 pictures; $begun were begun"

# ---- one picture -----------------------------------------------------------------------------------------------------

options=(--backend cpu --size 200x150 --samples 4)
gemtrace render scenes/brilliant.toml --output one.exr "${options[@]}" --quiet
mkdir parts
job=$(submit cluster/picture.sbatch scenes/brilliant.toml parts/one.exr "${options[@]}")
finish "$job"
gemtrace merge parts
cmp one.exr parts/one.exr || fail "the picture of eight parts differs"
say "eight tasks made one picture, the same bits"
say "passed"
