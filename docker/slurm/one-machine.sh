#!/usr/bin/env bash
# Runs Slurm on one machine, to try and to test builds on a cluster: docker/slurm/one-machine.sh --help
set -euo pipefail

nodes=4
cpus=1
memory_mb=4000
patience_s=30

usage() {
  cat <<'EOF'
usage: one-machine.sh [OPTIONS] -- COMMAND...     start a cluster, run COMMAND in it, stop the cluster
       one-machine.sh [OPTIONS] start FOLDER      start a cluster and keep it in FOLDER, a new folder
       one-machine.sh stop FOLDER                 stop it and remove FOLDER
       one-machine.sh kill-node FOLDER NODE       kill a node with its jobs, as a loss of power does
       one-machine.sh start-node FOLDER NODE      start it again

Starts slurmctld and several slurmd, with a munge daemon and a key of their own, as this user. They listen on the
address of the machine's host name. Changes no file outside of the folder, and needs no systemd. The nodes are
n1, n2, ...

  --nodes K        number of nodes (default: 4)
  --cpus N         cores of each node (default: 1)
  --memory MB      memory of each node (default: 4000); Slurm counts it, but limits no job here

COMMAND finds the cluster by the environment. After `start`, set SLURM_CONF=FOLDER/slurm.conf. The logs are in
FOLDER/log. docker/install-packages.sh cluster installs Slurm.
EOF
}

fail() {
  echo "one-machine.sh: $*" >&2
  exit 1
}

usage_error() {
  echo "one-machine.sh: $*; see one-machine.sh --help" >&2
  exit 2
}

fail_with_log() {  # LOG COMPLAINT
  tail -n 5 "$folder/log/$1.log" >&2 || true
  fail "$2; the end of its log is above"
}

wait_for() {  # LOG COMPLAINT COMMAND...; fails if COMMAND keeps failing
  local log="$1" complaint="$2" until=$((SECONDS + patience_s))
  shift 2
  until "$@" >/dev/null 2>&1; do
    ((SECONDS < until)) || fail_with_log "$log" "$complaint after $patience_s s"
    sleep 0.1
  done
}

# Prints the first of COUNT consecutive free ports. They are below those that the system gives to outgoing connections.
free_ports() {  # COUNT ADDRESS
  local first port
  for _ in {1..100}; do
    first=$((20000 + RANDOM % 10000))
    for ((port = first; port < first + $1; port++)); do
      ! (exec 3<>"/dev/tcp/$2/$port") 2>/dev/null || continue 2
    done
    echo "$first"
    return
  done
  fail "found no $1 consecutive free ports from 20000 to 30000"
}

write_configuration() {
  local address host port user version
  host="$(uname -n)"
  address="$(getent ahostsv4 "$host" | awk 'NR == 1 { print $1 }')" || true
  [[ -n "$address" ]] || fail "the host name $host has no address; add the line '127.0.0.1 $host' to /etc/hosts"
  host="${host%%.*}"
  user="$(id -un)"
  port="$(free_ports $((nodes + 1)) "$address")"
  version="$(slurmctld -V)"
  # Newer versions ask systemd for a control group unless this is set; 22.05 does not know it.
  [[ "$version" == *" 22."* ]] || echo "CgroupPlugin=disabled" >"$folder/cgroup.conf"
  cat >"$folder/slurm.conf" <<EOF
ClusterName=onemachine
SlurmctldHost=$host($address)
SlurmctldPort=$port
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
# A requeued job waits until its credential has expired, by default for 120 s.
AuthInfo=socket=$folder/munge.socket,cred_expire=5
CredType=cred/munge
# Listen on the address of the host name alone.
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/%n.pid
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool.%n
SlurmctldLogFile=$folder/log/slurmctld.log
SlurmdLogFile=$folder/log/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=1,sched_interval=2,bf_interval=2
ReturnToService=2
SlurmdTimeout=10
KillWait=5
MinJobAge=3600
NodeName=n[1-$nodes] NodeHostname=$host NodeAddr=$address Port=[$((port + 1))-$((port + nodes))] CPUs=$cpus RealMemory=$memory_mb
PartitionName=build Nodes=n[1-$nodes] Default=YES MaxTime=INFINITE State=UP
EOF
}

all_idle() { [[ "$(sinfo -h -N -t idle -o %N | wc -l)" == "$nodes" ]]; }

start_node() {  # NODE
  slurmd -N "$1" || fail_with_log "$1" "slurmd of $1 did not start"
}

start() {
  local node tool
  for tool in slurmctld slurmd sinfo munged; do
    command -v "$tool" >/dev/null || fail "$tool is not installed; docker/install-packages.sh cluster installs it"
  done
  ((${#folder} <= 60)) || fail "$folder is too long for the names of sockets; choose a path of at most 60 characters"
  mkdir "$folder/log" "$folder/state"
  (umask 077 && head -c 128 /dev/urandom >"$folder/munge.key")
  write_configuration
  export SLURM_CONF="$folder/slurm.conf"
  # --force: without it, munged refuses a folder that is closed to other users.
  munged --force --key-file="$folder/munge.key" --socket="$folder/munge.socket" --pid-file="$folder/munged.pid" \
    --log-file="$folder/log/munged.log" --seed-file="$folder/munge.seed" --num-threads=2 2>/dev/null ||
    fail_with_log munged "munged did not start"
  slurmctld || fail_with_log slurmctld "slurmctld did not start"
  for ((node = 1; node <= nodes; node++)); do
    start_node "n$node"
  done
  wait_for slurmctld "the $nodes nodes are not ready" all_idle
}

# Prints the processes that have one of the logs open, and their descendants: daemons and the jobs that they started.
processes_with() {  # LOG...
  local log pid open=" "
  local named=()
  for log in "$@"; do
    named+=(${named:+-o} -lname "$log")
  done
  for pid in $(find /proc/[0-9]*/fd \( "${named[@]}" \) 2>/dev/null | cut -d / -f 3 | sort -u); do
    open+="$pid "
  done
  { cat /proc/[0-9]*/status 2>/dev/null || true; } | awk -v open="$open" '
    $1 == "Pid:" { pid = $2 }
    $1 == "PPid:" { parent[pid] = $2 }
    END {
      for (pid in parent)
        for (up = pid; up > 1; up = parent[up])
          if (index(open, " " up " ")) { print pid; break }
    }'
}

has_ended() {  # PID; a zombie has ended, and waits for its parent
  local state
  state="$(awk '/^State:/ { print $2 }' "/proc/$1/status" 2>/dev/null)" || return 0
  [[ -z "$state" || "$state" == Z ]]
}

kill_processes_with() {  # LOG...
  local pids pid
  mapfile -t pids < <(processes_with "$@")
  ((${#pids[@]} > 0)) || return 0
  kill -KILL "${pids[@]}" 2>/dev/null || true
  for pid in "${pids[@]}"; do
    wait_for slurmctld "process $pid has not ended" has_ended "$pid"
  done
}

stop() {
  local node logs=("$folder/log/slurmctld.log" "$folder/log/munged.log")
  for node in $(sed -n 's/^NodeName=n\[1-\([0-9]*\)\].*/\1/p' "$folder/slurm.conf" 2>/dev/null | xargs -r seq); do
    logs+=("$folder/log/n$node.log")
  done
  kill_processes_with "${logs[@]}"
  kill_processes_with "${logs[@]}"  # started between the list and the kill
  rm -rf "$folder"
}

open_cluster() {  # FOLDER
  folder="$(realpath -- "$1")"
  [[ -f "$folder/slurm.conf" && -f "$folder/munge.key" ]] || fail "$1 has no cluster of one-machine.sh"
  export SLURM_CONF="$folder/slurm.conf"
}

open_node() {  # FOLDER NODE
  open_cluster "$1"
  [[ "$2" =~ ^n[0-9]+$ && -f "$folder/log/$2.log" ]] || fail "$1 has no node '$2'"
}

count() {  # OPTION VALUE
  [[ "$2" =~ ^[1-9][0-9]{0,6}$ ]] || usage_error "$1 needs a number, not '$2'"
  echo "$2"
}

while [[ $# -gt 0 ]]; do
  case "$1" in
    -h | --help)
      usage
      exit 0
      ;;
    --nodes) nodes="$(count "$1" "${2:-}")" ;;
    --cpus) cpus="$(count "$1" "${2:-}")" ;;
    --memory) memory_mb="$(count "$1" "${2:-}")" ;;
    *) break ;;
  esac
  shift 2
done

case "${1:-} $#" in
  "-- 1") usage_error "no command after --" ;;
  "-- "*)
    shift
    folder="$(mktemp -d /tmp/lodestream-slurm-XXXXXX)"
    trap stop EXIT
    trap 'exit 129' HUP
    trap 'exit 130' INT
    trap 'exit 143' TERM
    start
    "$@"
    ;;
  "start 2")
    mkdir -m 700 -- "$2" || fail "name a new folder"
    folder="$(realpath -- "$2")"
    trap stop EXIT
    start
    trap - EXIT
    echo "export SLURM_CONF=$folder/slurm.conf"
    ;;
  "stop 2")
    open_cluster "$2"
    stop
    ;;
  "kill-node 3")
    open_node "$2" "$3"
    kill_processes_with "$folder/log/$3.log"
    ;;
  "start-node 3")
    open_node "$2" "$3"
    start_node "$3"
    ;;
  *) usage_error "name a command with its arguments" ;;
esac
