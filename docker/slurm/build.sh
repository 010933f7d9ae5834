#!/usr/bin/env bash
# Builds a store on a Slurm cluster: docker/slurm/build.sh --help
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
program="$(command -v lodestreamd || true)"
cpus=8 memory=8G
task_cpus=1 task_memory=1G
at_once=200
wait=no
own_options="--part --task --tasks --threads --memory --tmp -o --output --resume"

usage() {
  cat <<'EOF'
usage: build.sh [SETTINGS] IN.ply OUT.lode N [OPTIONS of lodestreamd build]

Submits three jobs, each of which waits for the one before: prepare; simplify, an array of N tasks; finish. Prints
their ids. IN.ply, OUT.lode and the program must have the same path on all nodes, OUT.lode on a shared file
system. The same command again continues a build that failed or was cancelled.

  --cpus C, --mem M             cores and memory of prepare and of finish (default: 8, 8G)
  --task-cpus C, --task-mem M   cores and memory of each task (default: 1, 1G)
  --at-once K                   number of tasks that may run at the same time (default: 200)
  --program PATH                lodestreamd (default: that of PATH)
  --wait                        wait for the end, and exit with 0 if the store is complete

sbatch reads partition, account and time limit from SBATCH_PARTITION, SBATCH_ACCOUNT and SBATCH_TIMELIMIT. A job
gives lodestreamd 0.9 of its memory, its cores as --threads, and SLURM_TMPDIR or /tmp for temporary files of tasks.
EOF
}

fail() {
  echo "build.sh: $*" >&2
  exit 1
}

usage_error() {
  echo "build.sh: $*; see build.sh --help" >&2
  exit 2
}

while [[ "${1:-}" == -* ]]; do
  case "$1" in
    -h | --help)
      usage
      exit 0
      ;;
    --wait)
      wait=yes
      shift
      continue
      ;;
    --cpus) cpus="${2:-}" ;;
    --mem) memory="${2:-}" ;;
    --task-cpus) task_cpus="${2:-}" ;;
    --task-mem) task_memory="${2:-}" ;;
    --at-once) at_once="${2:-}" ;;
    --program) program="$(command -v -- "${2:-}")" || usage_error "no program '${2:-}'" ;;
    *) usage_error "unknown setting $1" ;;
  esac
  [[ $# -ge 2 ]] || usage_error "$1 needs a value"
  shift 2
done
[[ $# -ge 3 ]] || usage_error "name the input, the output and the number of tasks"
[[ -n "$program" ]] || fail "lodestreamd is not in PATH; name it with --program"
[[ -r "$1" ]] || fail "cannot read $1"
[[ -d "$(dirname -- "$2")" ]] || fail "no folder $(dirname -- "$2")"
[[ "$3" =~ ^[1-9][0-9]{0,6}$ ]] || usage_error "'$3' is no number of tasks"
program="$(realpath -- "$program")"
input="$(realpath -s -- "$1")"
output="$(realpath -s -- "$2")"
tasks="$3"
shift 3
[[ "$output" != *[%\\]* ]] || fail "the output's path contains % or \\, which Slurm would replace in the names of logs"
for option in "$@"; do
  [[ " $own_options " != *" ${option%%=*} "* ]] || usage_error "${option%%=*} is set by this script"
done
command -v sbatch >/dev/null || fail "sbatch is not in PATH; run this on a machine that submits jobs"
most_tasks="$(scontrol show config | awk '$1 == "MaxArraySize" { print $3 }')"
((tasks <= ${most_tasks:-1001})) || fail "this cluster allows arrays of at most $most_tasks tasks (MaxArraySize)"

submitted=()
cancel_submitted() {
  [[ ${#submitted[@]} -eq 0 ]] || scancel "${submitted[@]}"
}
trap cancel_submitted EXIT

submit() {  # PART LOG CPUS MEMORY [OPTIONS of sbatch]...; appends the job's id to submitted
  local part="$1" id
  id="$(sbatch --parsable --requeue --open-mode=append --job-name="$part-${output##*/}" --output="$output.log/$2" --nodes=1 \
    --ntasks=1 --cpus-per-task="$3" --mem="$4" "${@:5}" "$here/part.sh" "$part" "$program" "$input" "$output" "$tasks" \
    "${build_options[@]}")"
  submitted+=("${id%%;*}")
}

build_options=("$@")
mkdir -p -- "$output.log"
submit prepare prepare.out "$cpus" "$memory"
submit simplify simplify-%a.out "$task_cpus" "$task_memory" --array="0-$((tasks - 1))%$at_once" \
  --dependency="afterok:${submitted[0]}" --kill-on-invalid-dep=yes
submit finish finish.out "$cpus" "$memory" --dependency="afterok:${submitted[1]}" --kill-on-invalid-dep=yes
trap - EXIT

jobs="${submitted[*]}"
cat <<EOF
jobs: prepare ${submitted[0]}, simplify ${submitted[1]}, finish ${submitted[2]}
logs: $output.log
follow: squeue -j ${jobs// /,}
cancel: scancel $jobs
EOF
[[ "$wait" == yes ]] || exit 0

state=PENDING
until [[ "$state" =~ ^(COMPLETED|FAILED|CANCELLED|TIMEOUT|DEADLINE|OUT_OF_MEMORY|BOOT_FAIL|NODE_FAIL|PREEMPTED)$ ]]; do
  sleep 2
  state="$(squeue -h -t all -j "${submitted[2]}" -o %T)" || fail "cannot ask Slurm for the state of job ${submitted[2]}"
done
[[ "$state" == COMPLETED ]] || fail "not complete, job ${submitted[2]} is $state; read $output.log and run the same command again"
echo "complete: $output"
