#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Starts, lists and stops tessera-slave on the machines of a LAN, over ssh.
set -euo pipefail

usage() {
  cat <<'END'
Usage: launch-slaves.sh start|list|stop [options] HOST...

HOST is host, user@host or user@host:port; ssh must log in without asking (keys or an agent).

  start   copies the binary and the host's key folder to ~/.tessera on each host and starts a slave there
  list    says for each host whether its slave runs
  stop    ends the slaves with TERM: tiles in work go back to the master

Options
  --master HOST:PORT  where the master listens (start)
  --keys DIR          the cluster folder that `tessera-keys init DIR` made (start); a host without a key folder in it gets
                      one by `tessera-keys add DIR slave NAME`. Without: plain TCP, for a master on loopback only
  --binary PATH       tessera-slave to copy (default: beside this script, else from PATH)
  --threads N         render threads of each slave (default: all)
  --folder DIR        on the hosts, absolute or below the home (default: .tessera)
  --ssh-option OPT    passed on to ssh as -o OPT; may be given several times
  --help

A slave's name is its host's, with -PORT behind it where a port is given.
Exit code: 0 done on every host, 1 failed on some (each with a line), 2 wrong usage.
END
}

wrong_usage() {
  echo "launch-slaves.sh: $1 (see --help)" >&2
  exit 2
}

fail() {
  echo "launch-slaves.sh: $1" >&2
  return 1
}

# Values go through the remote shell, so they are checked to hold the characters of a pattern alone.
check_word() {  # arguments: what it is, its value, regular expression
  [[ $2 =~ ^$3$ ]] || wrong_usage "$1 '$2' is not of the form $3"
}

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
action='' master='' keys='' binary='' threads='' folder=.tessera
hosts=() ssh_options=(-o BatchMode=yes -o ConnectTimeout=10)

parse() {
  while (($# > 0)); do
    case $1 in
      --help | -h) usage; exit 0 ;;
      --master | --keys | --binary | --threads | --folder | --ssh-option)
        (($# >= 2)) || wrong_usage "$1 needs a value"
        case $1 in
          --master) master=$2 ;;
          --keys) keys=$2 ;;
          --binary) binary=$2 ;;
          --threads) threads=$2 ;;
          --folder) folder=$2 ;;
          --ssh-option) ssh_options+=(-o "$2") ;;
        esac
        shift 2
        ;;
      -*) wrong_usage "unknown option $1" ;;
      *)
        if [[ -z $action ]]; then action=$1; else hosts+=("$1"); fi
        shift
        ;;
    esac
  done
  case $action in
    start | list | stop) ;;
    '') wrong_usage "say start, list or stop" ;;
    *) wrong_usage "unknown action '$action'; there are start, list and stop" ;;
  esac
  ((${#hosts[@]} > 0)) || wrong_usage "no HOST given"
  local host
  for host in "${hosts[@]}"; do
    check_word HOST "$host" '([A-Za-z0-9_][A-Za-z0-9._-]*@)?[A-Za-z0-9][A-Za-z0-9._-]*(:[0-9]+)?'
  done
  check_word --folder "$folder" '[A-Za-z0-9._/-]+'
}

find_binary() {
  if [[ -z $binary ]]; then
    if [[ -x $here/tessera-slave ]]; then
      binary=$here/tessera-slave
    else
      binary=$(command -v tessera-slave) || wrong_usage "no tessera-slave beside this script or in PATH: give --binary"
    fi
  fi
  [[ -f $binary && -r $binary ]] || wrong_usage "--binary $binary: no such file"
}

check_start() {
  [[ -n $master ]] || wrong_usage "start needs --master HOST:PORT"
  check_word --master "$master" '[][A-Za-z0-9._:-]+:[0-9]+'
  [[ -z $threads ]] || check_word --threads "$threads" '[1-9][0-9]*'
  find_binary
  if [[ -n $keys ]]; then
    [[ -d $keys ]] || wrong_usage "--keys $keys: no such folder; make it with: tessera-keys init $keys"
  elif [[ ! $master =~ ^(127\.|localhost:|\[::1\]) ]]; then
    wrong_usage "a master beyond loopback needs --keys DIR; make it with: tessera-keys init DIR"
  fi
}

name_of() {  # prints host-port for user@host:port
  local name=${1#*@}
  echo "${name/:/-}"
}

remote() {  # runs a script with arguments (checked words) on a host; standard input goes to the script
  local host=$1 script=$2 port=() words='' word
  shift 2
  for word in "$@"; do words+=" '$word'"; done
  if [[ $host == *:* ]]; then
    port=(-p "${host##*:}")
    host=${host%:*}
  fi
  # The script is fixed text without single quotes; arguments hold only checked characters.
  ssh "${ssh_options[@]}" "${port[@]}" -- "$host" "sh -c '$script' sh$words"
}

# These scripts run on the hosts: POSIX sh without single quotes, expanded there and not here. $1 is
# the folder, $2 the slave's name.
# shellcheck disable=SC2016
readonly find_slave='
pid=
if cd "$1" 2>/dev/null && [ -f "$2.pid" ]; then pid=$(cat "$2.pid"); fi
if [ -n "$pid" ] && ! tr "\0" " " <"/proc/$pid/cmdline" 2>/dev/null | grep -q -e "tessera-slave.* --name $2 "; then
  pid=
fi
'
# shellcheck disable=SC2016
readonly put_binary='
umask 077
mkdir -p "$1" && chmod 700 "$1" && cd "$1" || exit 1
cat >"tessera-slave.$2.new" && chmod 700 "tessera-slave.$2.new" && mv -f "tessera-slave.$2.new" tessera-slave
'
# shellcheck disable=SC2016
readonly put_keys='
umask 077
mkdir -p "$1/$2" && chmod 700 "$1/$2" && tar -C "$1/$2" -xf - && chmod 600 "$1/$2/node.key"
'
# shellcheck disable=SC2016
readonly start_slave="$find_slave"'
if [ -n "$pid" ]; then echo "runs already, pid $pid"; exit 0; fi
name=$2 master=$3 credentials=$4 threads=$5
set -- --master "$master" --name "$name"
if [ "$credentials" = keys ]; then set -- "$@" --keys "$PWD/$name"; else set -- "$@" --plain; fi
if [ "$threads" != all ]; then set -- "$@" --threads "$threads"; fi
umask 077
setsid nohup ./tessera-slave "$@" </dev/null >"$name.log" 2>&1 &
pid=$!
echo "$pid" >"$name.pid"
sleep 1
if kill -0 "$pid" 2>/dev/null; then echo "started, pid $pid"; exit 0; fi
rm -f "$name.pid"
echo "ended at once: $(tail -n 1 "$name.log")"
exit 1
'
# shellcheck disable=SC2016
readonly list_slave="$find_slave"'
if [ -n "$pid" ]; then echo "runs, pid $pid"; else echo "does not run"; fi
'
# shellcheck disable=SC2016
readonly stop_slave="$find_slave"'
if [ -z "$pid" ]; then echo "does not run"; exit 0; fi
kill -TERM "$pid"
for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20; do
  if ! kill -0 "$pid" 2>/dev/null; then rm -f "$2.pid"; echo "stopped"; exit 0; fi
  sleep 0.5
done
echo "pid $pid still runs ten seconds after TERM"
exit 1
'

ensure_keys() {  # makes the key folder of the slave with this name where there is none
  [[ -f $keys/$1/node.key ]] && return 0
  local tool
  tool=$(dirname "$binary")/tessera-keys
  [[ -x $tool ]] || tool=$(command -v tessera-keys) ||
    { fail "$keys has no folder $1 and there is no tessera-keys to make it"; return 1; }
  "$tool" add "$keys" slave "$1" >/dev/null || fail "tessera-keys add $keys slave $1 failed"
}

start_on() {  # copies the binary and the keys to a host and starts the slave with this name there
  local running
  running=$(remote "$1" "$list_slave" "$folder" "$2" </dev/null) || return 1
  if [[ $running == runs,* ]]; then
    echo "runs already${running#runs}"
    return 0
  fi
  remote "$1" "$put_binary" "$folder" "$2" <"$binary" || return 1
  local credentials=plain
  if [[ -n $keys ]]; then
    credentials=keys
    ensure_keys "$2" || return 1
    local files=(ca.crt node.crt node.key)
    if [[ -f $keys/$2/crl.pem ]]; then files+=(crl.pem); fi
    tar -C "$keys/$2" -cf - "${files[@]}" | remote "$1" "$put_keys" "$folder" "$2" || return 1
  fi
  remote "$1" "$start_slave" "$folder" "$2" "$master" "$credentials" "${threads:-all}" </dev/null
}

main() {
  parse "$@"
  if [[ $action == start ]]; then check_start; fi
  local host name answer failures=0
  for host in "${hosts[@]}"; do
    name=$(name_of "$host")
    case $action in
      start) answer=$(start_on "$host" "$name") || failures=$((failures + 1)) ;;
      list) answer=$(remote "$host" "$list_slave" "$folder" "$name" </dev/null) || failures=$((failures + 1)) ;;
      stop) answer=$(remote "$host" "$stop_slave" "$folder" "$name" </dev/null) || failures=$((failures + 1)) ;;
    esac
    echo "$host: ${answer:-failed (see the line above)}"
  done
  ((failures == 0)) || fail "$action failed on $failures of ${#hosts[@]} hosts"
}

main "$@"
