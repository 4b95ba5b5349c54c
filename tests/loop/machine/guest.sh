#!/bin/sh
# Runs in the virtual machine as its first and only script. Each run of the controller is framed by lines "RUN name" and "END code";
# the host side (machine.py) judges.
emulator() {
  sanso-emulator --usb --world hung --dir /tmp/robot > /tmp/emulator.log 2>&1 &
  emulator=$!
  for i in $(seq 100); do grep -q ready /tmp/emulator.log && break; sleep 0.1; done
  sleep 1.5  # the kernel gets to know the devices
}
load() {  # ordinary programs that want the processor, memory and the disk
  [ "$1" = loaded ] || return
  ( while :; do :; done ) & burners=$!
  ( while :; do dd if=/dev/zero of=/tmp/junk bs=64k count=64 2>/dev/null; done ) & burners="$burners $!"
  ( while :; do ls -lR /sys/devices > /dev/null 2>&1; done ) & burners="$burners $!"
}
# run NAME CONFIGURATION LOAD SECONDS
run() {
  echo "RUN $1"
  rm -rf /tmp/log && mkdir -p /tmp/log
  burners=
  sanso-firmware --config "/etc/sanso/$2.toml" < /dev/null > /tmp/out 2>&1 &
  firmware=$!
  for i in $(seq 100); do grep -q ' idle$' /tmp/out && break; sleep 0.1; done
  load "$3"
  sleep "$4"
  [ -n "$burners" ] && kill $burners
  kill -TERM $firmware
  wait $firmware
  echo "END $?"
  cat /tmp/out
  for f in /tmp/log/times-*.csv; do echo "TIMES"; cat "$f"; done
  echo "OVER"
}
# the cable of the bus is pulled and put back under a running controller
replug() {
  echo "RUN $1"
  sanso-firmware --config "/etc/sanso/$2.toml" < /dev/null > /tmp/out 2>&1 &
  firmware=$!
  for i in $(seq 100); do grep -q ' idle$' /tmp/out && break; sleep 0.1; done
  for i in 1 2; do
    sanso-emulator --dir /tmp/robot --tell '{"command": "unplug_bus"}' > /dev/null
    sleep 1
    sanso-emulator --dir /tmp/robot --tell '{"command": "replug_bus"}' > /dev/null
    sleep 2
  done
  kill -TERM $firmware
  wait $firmware
  echo "END $?"
  cat /tmp/out
  echo "OVER"
}
echo "KERNEL $(uname -r) realtime $(cat /sys/kernel/realtime)"
emulator
sanso-firmware --devices
echo "EMULATOR"; cat /tmp/emulator.log
while read -r line; do $line; done < /etc/sanso/runs
echo "DONE"
