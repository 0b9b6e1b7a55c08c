#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A real Slurm cluster on this machine, for tests: slurmctld and several slurmd on loopback, from Debian's packages, as the
# calling user, without root rights, munge or database. Everything lies in FOLDER; the nodes n1, n2, ... claim 4 CPUs
# and 4000 MB each, whatever the machine has.
# usage: test_cluster.sh start FOLDER [nodes] | stop FOLDER | kill FOLDER NODE | revive FOLDER NODE
#        | kill-controller FOLDER | start-controller FOLDER | is-there
# After start: export SLURM_CONF=FOLDER/slurm.conf, and sbatch, squeue, scontrol, scancel speak to it.
set -eu

usage() { sed -n 's/^# usage: /usage: /p; s/^#        | /       | /p' "$0" >&2; exit 2; }

need_slurm() {
  for program in slurmctld slurmd sbatch squeue scontrol; do
    PATH=$PATH:/usr/sbin:/sbin command -v "$program" >/dev/null || {
      echo "$program is not installed; on Debian: apt-get install slurmctld slurmd slurm-client slurm-wlm-basic-plugins" >&2
      exit 77
    }
  done
  if PATH=$PATH:/usr/sbin:/sbin; readlink -f "$(command -v slurmd)" | grep -q emulator; then
    echo "slurmd is the emulator: remove the package slurm-wlm-emulator" >&2
    exit 77
  fi
}

# Alive, and no zombie: process 1 of a container may not reap.
alive() { case $(sed -n 's/^State:[[:space:]]*\(.\).*/\1/p' "/proc/$1/status" 2>/dev/null) in "" | Z | X) return 1 ;; esac; }

# A port for the controller and one for each node, none of them in use.
free_ports() {
  python3 - "$1" <<'PY'
import random, socket, sys
count = int(sys.argv[1]) + 1
for _ in range(200):
    base = random.randrange(20000, 32000)  # below the range that outgoing connections take
    held = []
    try:
        for port in range(base, base + count):
            held.append(socket.socket())
            held[-1].bind(("127.0.0.1", port))
        print(base)
        break
    except OSError:
        pass
    finally:
        for one in held:
            one.close()
PY
}

write_conf() {
  user=$(id -un) host=$(hostname -s) base=$(free_ports "$2")
  cat >"$1/slurm.conf" <<CONF
ClusterName=testcluster
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$base
AuthType=auth/none
CredType=cred/none
AuthInfo=cred_expire=5
SlurmUser=$user
SlurmdUser=$user
MpiDefault=none
TaskPlugin=task/none
ProctrackType=proctrack/linuxproc
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=1
JobAcctGatherParams=OverMemoryKill
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc=$1/log/jobcomp.txt
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=batch_sched_delay=0,sched_interval=1,bf_interval=1
StateSaveLocation=$1/state
SlurmdSpoolDir=$1/spool/%n
SlurmctldPidFile=$1/slurmctld.pid
SlurmdPidFile=$1/slurmd-%n.pid
SlurmctldLogFile=$1/log/slurmctld.log
SlurmdLogFile=$1/log/slurmd-%n.log
ReturnToService=2
SlurmdTimeout=10
KillWait=2
MinJobAge=300
MessageTimeout=5
SlurmdParameters=config_overrides
NodeName=n[1-$2] NodeHostname=$host NodeAddr=127.0.0.1 Port=[$((base + 1))-$((base + $2))] CPUs=4 RealMemory=4000
PartitionName=main Nodes=n[1-$2] Default=YES State=UP DefMemPerCPU=500
CONF
}

# The daemons stay in the foreground of their own sessions, so that their process ids are known.
start_controller() {
  setsid slurmctld -D "$@" -f "$folder/slurm.conf" >"$folder/log/slurmctld.out" 2>&1 </dev/null &
  echo $! >"$folder/controller.id"
}
start_node() {
  setsid slurmd -D -N "$1" -f "$folder/slurm.conf" >"$folder/log/slurmd-$1.out" 2>&1 </dev/null &
  echo $! >"$folder/node-$1.id"
}

wait_idle() {
  for _ in $(seq 200); do
    [ "$(sinfo -h -o '%t %D' 2>/dev/null)" = "idle $1" ] && return 0
    sleep 0.02
  done
  echo "the cluster in $folder does not come up; sinfo says: $(sinfo -h 2>&1); see $folder/log" >&2
  return 1
}

# Everything below the process, the process first.
family() {
  echo "$1"
  for child in $(cat /proc/"$1"/task/*/children 2>/dev/null); do family "$child"; done
}

# Steps outlive their slurmd; each holds the log of its node open.
steps_of() {  # node, or nothing for all
  for id in $(pgrep -x slurmstepd); do
    ls -l "/proc/$id/fd" 2>/dev/null | grep -q "$folder/log/slurmd-${1:-.*}\.log" && echo "$id"
  done
  return 0
}

end_all() {  # signal, process ids
  signal=$1
  shift
  for id in "$@"; do kill "-$signal" "$id" 2>/dev/null || true; done
}

stop() {
  [ -f "$folder/slurm.conf" ] || { echo "no cluster in $folder" >&2; return 0; }
  if [ -f "$folder/controller.id" ] && alive "$(cat "$folder/controller.id")"; then
    timeout 5 scancel -u "$(id -un)" 2>/dev/null || true
    for _ in $(seq 100); do
      [ -z "$(timeout 5 squeue -h 2>/dev/null)" ] && break
      sleep 0.05
    done
  fi
  ids=$(cat "$folder"/node-*.id "$folder/controller.id" 2>/dev/null || true)
  for id in $(steps_of); do
    # shellcheck disable=SC2046  # ids are words
    end_all KILL $(family "$id")
  done
  # shellcheck disable=SC2086
  end_all TERM $ids
  for _ in $(seq 250); do
    left=
    for id in $ids; do alive "$id" && left="$left $id"; done
    [ -n "$left" ] || break
    sleep 0.02
  done
  # shellcheck disable=SC2086
  end_all KILL $left
  rm -f "$folder"/node-*.id "$folder/controller.id"
}

PATH=$PATH:/usr/sbin:/sbin
[ $# -ge 1 ] || usage
action=$1
shift
if [ "$action" = is-there ]; then
  need_slurm
  exit 0
fi
[ $# -ge 1 ] || usage
case $1 in /*) folder=$1 ;; *) folder=$PWD/$1 ;; esac
shift
export SLURM_CONF="$folder/slurm.conf"

case $action in
  start)
    need_slurm
    nodes=${1:-4}
    mkdir -p "$folder/log" "$folder/state" "$folder/spool"
    for k in $(seq "$nodes"); do mkdir -p "$folder/spool/n$k"; done
    write_conf "$folder" "$nodes"
    start_controller -c -i
    for k in $(seq "$nodes"); do start_node "n$k"; done
    wait_idle "$nodes" || { stop; exit 1; }
    ;;
  stop) stop ;;
  kill)
    [ $# -eq 1 ] || usage
    end_all KILL "$(cat "$folder/node-$1.id")"
    for id in $(steps_of "$1"); do
      # shellcheck disable=SC2046
      end_all KILL $(family "$id")
    done
    ;;
  revive)
    [ $# -eq 1 ] || usage
    start_node "$1"
    ;;
  kill-controller) end_all KILL "$(cat "$folder/controller.id")" ;;
  start-controller) start_controller ;;
  *) usage ;;
esac
