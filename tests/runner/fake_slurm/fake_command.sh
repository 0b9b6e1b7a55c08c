#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Stands for every command of Slurm, by the name it is called by. $FAKE_SLURM is a folder: NAME.calls gets a line per call;
# NAME.reply, a shell text, answers where it is there; `queue` is what squeue shows.
name=${0##*/}
echo "$*" >>"$FAKE_SLURM/$name.calls"
if [ -f "$FAKE_SLURM/$name.reply" ]; then
  . "$FAKE_SLURM/$name.reply"
  exit
fi
case $name in
  sbatch)  # no other process: these start thousands of times
    number=100
    while read -r _; do number=$((number + 1)); done <"$FAKE_SLURM/sbatch.calls"
    echo $number
    ;;
  squeue)
    [ -f "$FAKE_SLURM/queue" ] || exit 0
    while IFS= read -r line; do printf '%s\n' "$line"; done <"$FAKE_SLURM/queue"
    ;;
  sinfo) printf '4000\n16000+\n' ;;
  scontrol) echo 'MaxArraySize            = 1001' ;;
esac
