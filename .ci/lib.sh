#!/usr/bin/env bash
# shellcheck disable=SC2034  # variables are used by the scripts that source this
# Shared by the scripts of this folder: where things are, and how a step is shown. Sourced by bash.

set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

root=$PWD
logs=build/logs
results=build/test-results
jobs=$(nproc)
mkdir -p "$logs"

# The Node that runs npm comes first: Debian's emscripten brings an older one as /usr/bin/node.
if [[ -n ${npm_node_execpath:-} ]]; then PATH=$(dirname "$npm_node_execpath"):$PATH; fi
PATH=$root/node_modules/.bin:$PATH
export PATH
# Emscripten finds the acorn package of Debian here.
export NODE_PATH=/usr/share/nodejs

if [[ -t 1 ]]; then
  live=1 green=$'\e[32m' red=$'\e[31m' dim=$'\e[2m' bold=$'\e[1m' plain=$'\e[0m'
else
  live='' green='' red='' dim='' bold='' plain=''
fi

child='' beside=''
# Ctrl-C and SIGTERM end the step that runs, what `aside` has started, then the script.
interrupted() {
  trap '' INT TERM
  local process
  for process in $child $beside; do
    kill -TERM "$process" 2>/dev/null || true
    wait "$process" 2>/dev/null || true
  done
  printf '\n%s\n' "Stopped."
  exit 130
}
trap interrupted INT TERM

seconds_since() {
  printf '%d.%d s' $(((${EPOCHREALTIME/./} - $1) / 1000000)) \
    $(((${EPOCHREALTIME/./} - $1) / 100000 % 10))
}

# failures_in LOG: what GoogleTest and the sanitizers say of failures, which may be far from the end.
failures_in() {
  grep -aE -m 6 -A 8 ': Failure$|(WARNING|ERROR): [A-Za-z]+Sanitizer|: runtime error: ' "$1" || return 0
  echo
}

# step LABEL HINT COMMAND…: runs a command with its output in a log, and shows the label, the time,
# and on a terminal the last line of the log. If the command fails, the script ends. It
# prints the name of the step, the last lines and the path of the log, and the hint.
step() {
  local label=$1 hint=$2 begin=${EPOCHREALTIME/./} status=0
  shift 2
  local name=${label,,}
  local log=$logs/${name//[^a-z0-9]/-}.log
  if [[ -n $live ]]; then
    "$@" >"$log" 2>&1 </dev/null &
    child=$!
    while kill -0 "$child" 2>/dev/null; do
      local last
      last=$(tail -c 400 "$log" 2>/dev/null | tr '\r' '\n' | sed '/^[[:space:]]*$/d' | tail -n 1) || true
      printf '\r\e[K  %s %s %s' "$label" "$dim$(seconds_since "$begin")$plain" "$dim${last:0:60}$plain"
      sleep 0.2
    done
    printf '\r\e[K'
  else
    printf '  %s …\n' "$label"
    "$@" >"$log" 2>&1 </dev/null &
    child=$!
  fi
  wait "$child" || status=$?
  child=
  if ((status == 0)); then
    printf '%s✓%s %s %s\n' "$green" "$plain" "$label" "$dim$(seconds_since "$begin")$plain"
    return 0
  fi
  printf '%s✗ %s failed%s after %s (exit status %d). From %s:\n\n' \
    "$red" "$label" "$plain" "$(seconds_since "$begin")" "$status" "$log"
  failures_in "$log" | cut -c -400 | sed 's/^/    /'
  tail -n "${STEP_TAIL:-25}" "$log" | cut -c -400 | sed 's/^/    /'
  printf '\n%sWhat to do:%s %s\n' "$bold" "$plain" "$hint"
  return "$status"
}

# aside COMMAND…: starts a function of steps in parallel to the following steps. The output of both is
# interleaved by whole lines.
aside() {
  live=''
  {
    trap 'kill -TERM "$child" 2>/dev/null; exit 130' TERM
    child=''
    "$@"
  } &
  beside=$!
}

# fingerprint FILE…: changes when one of the files (folders: any file below) changes.
fingerprint() {
  { find "$@" -type f -printf '%p %s %T@\n' 2>/dev/null || true; } | LC_ALL=C sort | sha256sum | cut -d ' ' -f 1
}

# is_current STAMP FINGERPRINT: whether the stamp file holds the fingerprint.
is_current() { [[ -f $1 && $(<"$1") == "$2" ]]; }
