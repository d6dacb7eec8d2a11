# SPDX-License-Identifier: Apache-2.0
"""Slurm on this machine: a controller and two node daemons (na, nb), with an authentication daemon of their own. Needs
root and Debian's packages slurm-wlm and munge."""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time

CONF = '''ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmctldPort={port}
AuthType=auth/munge
AuthInfo=socket={root}/munge/munge.socket
StateSaveLocation={root}/state
SlurmdSpoolDir={root}/spool.%n
SlurmctldPidFile={root}/slurmctld.pid
SlurmdPidFile={root}/slurmd.%n.pid
SlurmctldLogFile={root}/slurmctld.log
SlurmdLogFile={root}/slurmd.%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=2,batch_sched_delay=0
Prolog={root}/prolog
ReturnToService=2
SlurmdTimeout=10
MinJobAge=300
KillWait=2
MpiDefault=none
JobCompType=jobcomp/none
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
NodeName=na NodeHostname={host} NodeAddr=127.0.0.1 Port={na} CPUs=2 State=UNKNOWN
NodeName=nb NodeHostname={host} NodeAddr=127.0.0.1 Port={nb} CPUs=2 State=UNKNOWN
PartitionName=all Nodes=na,nb Default=YES MaxTime=INFINITE State=UP
'''


def missing():
    """Why there can be no cluster; empty: there can."""
    if os.geteuid() != 0:
        return 'it needs root'
    for tool in 'slurmctld', 'slurmd', 'sbatch', 'squeue', 'munged', 'setpriv':
        if not shutil.which(tool, path=os.environ.get('PATH', '') + ':/usr/sbin:/sbin'):
            return f'{tool} is not installed (apt install slurm-wlm munge)'
    return ''


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(('127.0.0.1', 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Cluster:
    def __init__(self, root):
        self.root = pathlib.Path(root)
        os.environ['PATH'] += ':/usr/sbin:/sbin'
        self.daemons = {}
        munge = self.root / 'munge'
        munge.mkdir(parents=True)
        for folder in self.root.parents:
            if folder != pathlib.Path('/') and folder != pathlib.Path('/tmp'):
                folder.chmod(0o755)
        self.root.chmod(0o755)
        (munge / 'munge.key').write_bytes(os.urandom(1024))
        for path in munge, munge / 'munge.key':
            shutil.chown(path, 'munge', 'munge')
        munge.chmod(0o755)
        (munge / 'munge.key').chmod(0o400)
        port, na, nb = free_ports(3)
        self.conf = self.root / 'slurm.conf'
        host = socket.gethostname().split('.')[0]
        self.conf.write_text(CONF.format(host=host, root=self.root, port=port, na=na, nb=nb))
        (self.root / 'prolog').write_text(f'#!/bin/sh\n! grep -qs "^$SLURMD_NODENAME$" {self.root}/bad\n')
        (self.root / 'prolog').chmod(0o755)
        for folder in 'state', 'spool.na', 'spool.nb':
            (self.root / folder).mkdir()
        os.environ['SLURM_CONF'] = str(self.conf)
        self.start('munged')
        time.sleep(1)
        for name in 'slurmctld', 'na', 'nb':
            self.start(name)
        self.wait_for(lambda: self.call('sinfo', '--noheader', '--format=%D %t').split() == ['2', 'idle'])

    def start(self, name):
        munge = self.root / 'munge'
        command = {
            'munged': ['setpriv', '--reuid=munge', '--regid=munge', '--clear-groups', 'munged', '-F',
                       f'--key-file={munge}/munge.key', f'--socket={munge}/munge.socket',
                       f'--pid-file={munge}/munged.pid', f'--log-file={munge}/munged.log', f'--seed-file={munge}/seed'],
            'slurmctld': ['slurmctld', '-D', '-f', str(self.conf)],
        }.get(name, ['slurmd', '-D', '-N', name, '-f', str(self.conf)])
        with open(self.root / f'{name}.out', 'ab') as out:
            self.daemons[name] = subprocess.Popen(command, stdout=out, stderr=out, start_new_session=True)

    def kill(self, name):
        """As a power cut would."""
        self.daemons[name].kill()
        self.daemons[name].wait()

    def call(self, *command):
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout

    def wait_for(self, holds, patience=120):
        end = time.monotonic() + patience
        while not holds():
            if time.monotonic() > end:
                raise SystemExit(f'waited in vain: {self.call("sinfo", "-N", "-l")}{self.call("squeue")}')
            time.sleep(0.2)

    def stop(self):
        self.call('scancel', '--user=root')
        for name in 'na', 'nb', 'slurmctld', 'munged':
            if name in self.daemons and self.daemons[name].poll() is None:
                self.daemons[name].send_signal(signal.SIGTERM)
                try:
                    self.daemons[name].wait(10)
                except subprocess.TimeoutExpired:
                    self.daemons[name].kill()
