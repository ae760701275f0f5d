"""A Slurm cluster of one node, for tests: this machine, this user, a folder of its own.

With slurmctld and slurmd of Debian; no munge, no database, nothing of the system's is changed.
"""

import contextlib
import getpass
import os
import shutil
import socket
import subprocess
import time
from pathlib import Path

CONFIG = """
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port1}
SlurmdPort={port2}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/none
CredType=cred/none
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,batch_sched_delay=0,defer_batch
ReturnToService=2
MessageTimeout=60
SlurmctldTimeout=300
SlurmdTimeout=300
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""
PROGRAMS = ("slurmctld", "slurmd", "sbatch", "squeue", "sinfo", "scontrol")
READY_S = 120


def missing():
    """Programs that this machine does not have; slurmctld and slurmd lie in /usr/sbin."""
    path = os.environ.get("PATH", "") + ":/usr/sbin"
    return [name for name in PROGRAMS if not shutil.which(name, path=path)]


def free_ports(count):
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]


def logs(folder):
    return "\n".join(path.read_text(errors="replace")[-2000:] for path in folder.glob("*.log"))


@contextlib.contextmanager
def node(folder):
    """The environment in which sbatch finds the cluster; it ends with the block."""
    folder = Path(folder).resolve()
    (folder / "state").mkdir(parents=True)
    (folder / "spool").mkdir()
    ports = free_ports(2)
    config = folder / "slurm.conf"
    config.write_text(CONFIG.format(host=socket.gethostname().split(".")[0], folder=folder,
                                    user=getpass.getuser(), cpus=os.cpu_count(), port1=ports[0],
                                    port2=ports[1]))
    environment = {**os.environ, "SLURM_CONF": str(config),
                   "PATH": os.environ.get("PATH", "") + ":/usr/sbin"}
    daemons = []
    try:
        for name in ("slurmctld", "slurmd"):
            daemons.append(subprocess.Popen([name, "-D"], env=environment,
                                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        end = time.monotonic() + READY_S
        while "idle" not in subprocess.run(["sinfo", "--noheader", "--format=%t"], env=environment,
                                           capture_output=True, text=True).stdout:
            if time.monotonic() > end or any(one.poll() is not None for one in daemons):
                raise RuntimeError("slurm did not start:\n" + logs(folder))
            time.sleep(0.3)
        yield environment
    finally:
        for one in reversed(daemons):
            one.terminate()
        for one in daemons:
            one.wait(30)
