#!/usr/bin/env bash
# Runs one part of a build as a Slurm job: part.sh prepare|simplify|finish PROGRAM IN OUT N [OPTIONS of lodestreamd build]
# docker/slurm/build.sh submits it. Memory, threads and the folder for temporary files are those of the job.
set -euo pipefail

most_requeues=3
part="$1" program="$2" input="$3" output="$4" tasks="$5"
shift 5

command=("$program" build "$input" -o "$output" --part "$part" --tasks "$tasks" --threads "${SLURM_CPUS_PER_TASK:-1}")
name="$part"
if [[ "$part" == simplify ]]; then
  command+=(--task "$SLURM_ARRAY_TASK_ID" --tmp "${SLURM_TMPDIR:-/tmp}")
  name="$part, task $SLURM_ARRAY_TASK_ID of $tasks"
fi
memory_mib="${SLURM_MEM_PER_NODE:-$((${SLURM_MEM_PER_CPU:-0} * ${SLURM_CPUS_PER_TASK:-1}))}"
if ((memory_mib > 0)); then  # 0: all memory of the node
  command+=(--memory "$((memory_mib * 9 / 10))MiB")
fi

say() { echo "part.sh: $(date -u +%FT%TZ) $name on ${SLURMD_NODENAME:-$HOSTNAME}: $*" >&2; }

run_part() {
  local status=0
  "${command[@]}" "$@" || status=$?
  say "exit status $status"
  return "$status"
}

# Returns true if the part may succeed if it runs again: after a temporary failure, EX_TEMPFAIL, or a signal.
is_temporary() { (($1 == 75 || $1 >= 128)); }

say "starts, requeued ${SLURM_RESTART_COUNT:-0} times"
status=0
run_part "$@" || status=$?
if is_temporary "$status"; then  # at once, since Slurm lets a requeued job wait for two minutes
  status=0
  run_part "$@" || status=$?
fi
if is_temporary "$status" && ((${SLURM_RESTART_COUNT:-0} < most_requeues)); then
  say "is requeued"
  scontrol requeue "$SLURM_JOB_ID"
  sleep 60  # Slurm ends this run of the job
fi
exit "$status"
