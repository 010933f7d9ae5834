#!/usr/bin/env bash
# Builds a store with the Jobs of build-on-cluster.yaml: docker/kubernetes/build-on-cluster.sh --help
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
label="app.kubernetes.io/name=lodestream-build-on-cluster"
image=lodestream-builder
at_once=200
kubectl=(kubectl)

usage() {
  cat <<'EOF'
usage: build-on-cluster.sh [SETTINGS] IN.ply OUT.lode N [OPTIONS of lodestreamd build]
       build-on-cluster.sh [SETTINGS] --delete

Applies the Jobs prepare, simplify (N tasks) and finish, waits for each and deletes them at the end. IN.ply and
OUT.lode are paths on the volume lodestream-shared. If a Job fails, the Jobs stay for `kubectl logs`, and --delete
deletes them; finished work stays on the volume, and the same command continues it.

  --namespace NAME   of the Jobs and the volume (default: that of kubectl)
  --image IMAGE      with lodestreamd (default: lodestream-builder)
  --at-once K        number of tasks that may run at the same time (default: 200)

Cores and memory are those of build-on-cluster.yaml.
EOF
}

fail() {
  echo "build-on-cluster.sh: $*" >&2
  exit 1
}

usage_error() {
  echo "build-on-cluster.sh: $*; see build-on-cluster.sh --help" >&2
  exit 2
}

# Fails unless a word can stand between quotation marks in YAML.
check_word() {
  [[ "$1" =~ ^[A-Za-z0-9\ ._/=:,@+%-]+$ ]] || usage_error "'$1' has characters that this script does not pass on"
}

delete_jobs() { "${kubectl[@]}" delete jobs -l "$label" --ignore-not-found; }

# Prints the manifests with the names, numbers and options of this build.
manifests() {
  local text options="" option
  for option in "${build_options[@]}"; do
    options+=", \"$option\""
  done
  text="$(<"$here/build-on-cluster.yaml")"
  text="${text//"image: lodestream-builder"/"image: \"$image\""}"
  text="${text//"/shared/scan.ply"/"\"/shared/$input\""}"
  text="${text//"/shared/scan.lode"/"\"/shared/$output\""}"
  text="${text//"--tasks=16"/"--tasks=$tasks$options"}"
  text="${text//"completions: 16"/"completions: $tasks"}"
  text="${text//"parallelism: 16"/"parallelism: $((tasks < at_once ? tasks : at_once))"}"
  echo "$text"
}

# Returns true as soon as a Job is complete, false if it has failed.
wait_for() {  # JOB
  local failed
  until "${kubectl[@]}" wait --for=condition=complete --timeout=20s "job/$1" >/dev/null 2>&1; do
    failed="$("${kubectl[@]}" get "job/$1" -o "jsonpath={.status.conditions[?(@.type=='Failed')].status}")" ||
      fail "cannot ask for the state of job/$1"
    [[ "$failed" != True ]] || return 1
  done
}

delete_only=no
while [[ "${1:-}" == -* ]]; do
  case "$1" in
    -h | --help)
      usage
      exit 0
      ;;
    --delete)
      delete_only=yes
      shift
      continue
      ;;
    --namespace) kubectl+=(--namespace "${2:-}") ;;
    --image) image="${2:-}" ;;
    --at-once) at_once="${2:-}" ;;
    *) usage_error "unknown setting $1" ;;
  esac
  [[ $# -ge 2 ]] || usage_error "$1 needs a value"
  shift 2
done
command -v kubectl >/dev/null || fail "kubectl is not in PATH"
if [[ "$delete_only" == yes ]]; then
  delete_jobs
  exit
fi
[[ $# -ge 3 ]] || usage_error "name the input, the output and the number of tasks"
for word in "$image" "$@"; do
  check_word "$word"
done
[[ "$3" =~ ^[1-9][0-9]{0,6}$ ]] || usage_error "'$3' is no number of tasks"
[[ "$at_once" =~ ^[1-9][0-9]{0,6}$ ]] || usage_error "'$at_once' is no number of tasks"
input="${1#/}" output="${2#/}" tasks="$3"
shift 3
build_options=("$@")

existing="$("${kubectl[@]}" get jobs -l "$label" -o name)"
[[ -z "$existing" ]] || fail "jobs of an earlier build exist: ${existing//$'\n'/ }; delete them with --delete"
trap 'delete_jobs; exit 130' INT
trap 'delete_jobs; exit 143' TERM
for part in prepare simplify finish; do
  manifests | "${kubectl[@]}" apply -l "lodestream/part=$part" -f -
  wait_for "lodestream-$part" ||
    fail "job/lodestream-$part failed; see kubectl logs -l lodestream/part=$part --prefix, then delete the jobs with --delete"
done
delete_jobs
echo "complete: /shared/$output"
