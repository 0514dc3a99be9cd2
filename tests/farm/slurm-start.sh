#!/bin/bash
# Starts a Slurm of one node on the loopback, without systemd, control groups and accounting. As root.
#
# usage: slurm-start.sh FOLDER     state, logs and slurm.conf go there
set -euo pipefail
mkdir -p "${1:?folder}"
folder=$(cd "$1" && pwd)
node=$(hostname -s)
memory=$(awk '/MemTotal/ { print int($2 / 1024 * 0.9) }' /proc/meminfo)
mkdir -p "$folder"/{state,spool,log} /run/munge /var/log/munge /var/lib/munge /etc/munge /etc/slurm
[[ -s /etc/munge/munge.key ]] || head -c 1024 /dev/urandom > /etc/munge/munge.key
chown -R munge: /etc/munge /run/munge /var/log/munge /var/lib/munge
chmod 400 /etc/munge/munge.key
if ! munge -n > /dev/null 2>&1; then
  rm -f /run/munge/munge.socket.2*
  setpriv --reuid=munge --regid=munge --clear-groups /usr/sbin/munged < /dev/null > /dev/null 2>&1
  cp /run/munge/munged.pid "$folder/munged.pid"
fi
for _ in $(seq 50); do
  munge -n 2> /dev/null | unmunge > /dev/null 2>&1 && break
  sleep 0.1
done
cat > "$folder/slurm.conf" << CONF
ClusterName=loop
SlurmctldHost=$node(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CryptoType=crypto/munge
SlurmctldPort=16817
SlurmdPort=16818
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/log/slurmctld.log
SlurmdLogFile=$folder/log/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_interval=2,defer_batch
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
SwitchType=switch/none
ReturnToService=2
KillWait=5
NodeName=$node NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$memory State=UNKNOWN
PartitionName=render Nodes=$node Default=YES MaxTime=INFINITE State=UP
CONF
ln -sf "$folder/slurm.conf" /etc/slurm/slurm.conf
slurmctld -c < /dev/null > /dev/null 2>&1
slurmd -c < /dev/null > /dev/null 2>&1
for _ in $(seq 50); do
  sinfo -h -o %T 2> /dev/null | grep -q idle && exit 0
  sleep 0.2
done
echo "Slurm did not come up"
tail -n 20 "$folder"/log/*.log
exit 1
