#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Runs deploy/launch-slaves.sh against two ssh servers on loopback, with a slave that only sleeps.
# Usage: launch_slaves_test.sh [LAUNCH_SLAVES]. Exit 77: skipped, with the reason.
set -euo pipefail
launch=${1:-$(cd "$(dirname "$0")/../.." && pwd)/deploy/launch-slaves.sh}

skip() {
  echo "skipped: $1"
  exit 77
}
sshd=$(PATH=$PATH:/usr/sbin:/sbin command -v sshd) || skip "sshd is not installed (apt-get install openssh-server)"
command -v ssh >/dev/null || skip "ssh is not installed (apt-get install openssh-client)"

work=$(mktemp -d)
servers=()
cleanup() {
  local file
  for file in "$work"/remote/*.pid; do
    if [[ -f $file ]]; then kill "$(cat "$file")" 2>/dev/null || true; fi
  done
  if ((${#servers[@]} > 0)); then kill "${servers[@]}" 2>/dev/null || true; fi
  rm -rf "$work"
}
trap cleanup EXIT

fail() {
  echo "FAILED: $1"
  exit 1
}
expect() {  # arguments: what is checked, a text, a pattern that it must hold
  grep -q -e "$3" <<<"$2" || fail "$1: '$3' is not in: $2"
  echo "ok: $1"
}

ssh-keygen -q -t ed25519 -N '' -f "$work/host_key"
ssh-keygen -q -t ed25519 -N '' -f "$work/user_key"
cp "$work/user_key.pub" "$work/authorized"
# A server run by root keeps its children apart in this folder; systems make it when they start their own server.
if [[ $(id -u) == 0 ]]; then mkdir -p /run/sshd; fi

start_server() {  # starts an ssh server on a port; false when the port is taken
  cat >"$work/sshd_$1.conf" <<END
Port $1
ListenAddress 127.0.0.1
HostKey $work/host_key
AuthorizedKeysFile $work/authorized
PidFile none
StrictModes no
UsePAM no
PasswordAuthentication no
PermitRootLogin prohibit-password
END
  "$sshd" -D -e -f "$work/sshd_$1.conf" >"$work/sshd_$1.log" 2>&1 &
  local pid=$!
  for _ in $(seq 50); do
    if grep -q "Server listening" "$work/sshd_$1.log"; then
      servers+=("$pid")
      return 0
    fi
    kill -0 "$pid" 2>/dev/null || return 1
    sleep 0.1
  done
  kill "$pid"
  return 1
}

ports=()
for _ in $(seq 20); do
  port=$((20000 + RANDOM % 12000))
  if start_server "$port"; then ports+=("$port"); fi
  if ((${#ports[@]} == 2)); then break; fi
done
((${#ports[@]} == 2)) || skip "no ssh server starts here: $(tail -n 1 "$work"/sshd_*.log)"

options=(--folder "$work/remote" --ssh-option "IdentityFile=$work/user_key" --ssh-option IdentitiesOnly=yes
  --ssh-option StrictHostKeyChecking=no --ssh-option "UserKnownHostsFile=$work/known" --ssh-option LogLevel=ERROR)
user=$(id -un)
ssh -o BatchMode=yes -i "$work/user_key" -o IdentitiesOnly=yes -o StrictHostKeyChecking=no -o LogLevel=ERROR \
  -o "UserKnownHostsFile=$work/known" -p "${ports[0]}" -- "$user@127.0.0.1" true </dev/null ||
  skip "this account cannot log in by ssh: $(tail -n 1 "$work/sshd_${ports[0]}.log")"
hosts=("$user@127.0.0.1:${ports[0]}" "$user@127.0.0.1:${ports[1]}")
name=127.0.0.1-${ports[0]}

mkdir "$work/bin" "$work/cluster"
cat >"$work/bin/tessera-slave" <<'END'
#!/bin/bash
echo "arguments: $*"
trap 'echo ended by TERM; exit 0' TERM
while :; do sleep 0.1; done
END
cat >"$work/bin/tessera-keys" <<'END'
#!/bin/bash
[[ $1 == add && $3 == slave ]] || exit 2
mkdir -p "$2/$4"
for file in ca.crt node.crt node.key; do echo "$file of $4" >"$2/$4/$file"; done
chmod 644 "$2/$4/node.key"
END
cat >"$work/bin/broken-slave" <<'END'
#!/bin/bash
echo "cannot start: no such CPU"
exit 1
END
chmod +x "$work/bin/"*

start=(start --master 127.0.0.1:7400 --keys "$work/cluster" --binary "$work/bin/tessera-slave" --threads 3)
expect "nothing runs at first" "$("$launch" list "${options[@]}" "${hosts[0]}")" "does not run"

answer=$("$launch" "${start[@]}" "${options[@]}" "${hosts[@]}")
[[ $(grep -c "started, pid" <<<"$answer") == 2 ]] || fail "start: $answer"
echo "ok: two slaves start"
arguments=$(cat "$work/remote/$name.log")
expect "the slave gets its arguments" "$arguments" \
  "--master 127.0.0.1:7400 --name $name --keys $work/remote/$name --threads 3"
expect "the key folder is the host's" "$(cat "$work/remote/$name/node.key")" "of $name"
[[ $(stat -c %a "$work/remote/$name/node.key") == 600 ]] || fail "the key can be read by others"
[[ $(stat -c %a "$work/remote/$name") == 700 ]] || fail "the key folder can be entered by others"
echo "ok: the key is the owner's alone"
pid=$(cat "$work/remote/$name.pid")
kill -0 "$pid" || fail "the slave does not live on after its ssh session"
expect "list finds both" "$("$launch" list "${options[@]}" "${hosts[@]}" | grep -c "runs, pid")" "^2$"
expect "a second start leaves it alone" "$("$launch" "${start[@]}" "${options[@]}" "${hosts[0]}")" \
  "runs already, pid $pid"

expect "stop ends one" "$("$launch" stop "${options[@]}" "${hosts[0]}")" "stopped"
if kill -0 "$pid" 2>/dev/null; then fail "the slave survived stop"; fi
expect "by TERM" "$(cat "$work/remote/$name.log")" "ended by TERM"
expect "the other runs on" "$("$launch" list "${options[@]}" "${hosts[1]}")" "runs, pid"
expect "stop of what does not run" "$("$launch" stop "${options[@]}" "${hosts[0]}")" "does not run"
echo $$ >"$work/remote/$name.pid"  # a process number that another program has got since
expect "a foreign process is not taken for a slave" "$("$launch" stop "${options[@]}" "${hosts[0]}")" "does not run"
rm "$work/remote/$name.pid"
expect "stop ends the other" "$("$launch" stop "${options[@]}" "${hosts[1]}")" "stopped"

if answer=$("$launch" start --master 127.0.0.1:7400 --binary "$work/bin/broken-slave" "${options[@]}" \
  "${hosts[0]}" 2>&1); then
  fail "a slave that ends at once counts as started"
fi
expect "a slave that ends at once is reported" "$answer" "ended at once: cannot start: no such CPU"

wrong() {  # arguments: a pattern of the message, and the words that must be refused with it
  local code=0 text
  text=$("$launch" "${@:2}" 2>&1) || code=$?
  [[ $code == 2 ]] || fail "$*: exit code $code, not 2"
  expect "refused: ${*:2}" "$text" "$1"
}
wrong "say start, list or stop"
wrong "no HOST given" list
wrong "unknown option" list --nonsense host
wrong "HOST" list 'host;reboot'
wrong "unknown option" list -oProxyCommand=x
wrong "HOST" list 'user@-oProxyCommand=x'
wrong "needs --master" start host
wrong "needs --keys" start --master 10.0.0.1:7400 --binary "$work/bin/tessera-slave" host
echo "passed"
