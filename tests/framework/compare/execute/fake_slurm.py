#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""sbatch, squeue, scancel, sacct and scontrol for tests, by the name under which it is called: arrays run on this
machine, two tasks at a time, one on the node na and one on nb. Folder $FAKE_SLURM: jobs/ID.json (state of each array),
calls.txt (one line per call). What goes wrong is said by files there:
  refuse      sbatch takes nothing; its text is the reason
  silent      squeue does not answer
  bad_node    its text is a node on which no task even starts
  lost_index  its text is the index of a task that is killed whenever it runs, after it said its last words
  hold        nothing starts while it is there
  early       its text is how often squeue is asked, after it calls a task COMPLETED, before its files come: late, as
              in a shared folder"""
import json
import os
import subprocess
import sys
import threading
import time

ROOT = os.environ['FAKE_SLURM']
LOCK = threading.Lock()


def text(name):
    try:
        with open(os.path.join(ROOT, name), encoding='utf8') as file:
            return file.read().strip()
    except FileNotFoundError:
        return None


def save(job):
    path = os.path.join(ROOT, 'jobs', f'{job["id"]}.json')
    with open(path + '.part', 'w', encoding='utf8') as file:
        json.dump(job, file)
    os.rename(path + '.part', path)


def count_looks():
    return sum(line.startswith('squeue ') for line in text('calls.txt').split('\n'))


def set_state(job, index, state, node=''):
    with LOCK:
        job['tasks'][index] = [state, node]
        save(job)


def private_copy(shared, name):
    """A folder of an array as a node sees it that does not share what it writes."""
    copy = os.path.join(ROOT, 'nodes', name, 'batch')
    for folder in 'images', 'ended', 'log':
        os.makedirs(os.path.join(copy, folder))
    with open(os.path.join(shared, 'tasks.jsonl'), encoding='utf8') as tasks:
        lines = tasks.read()
    with open(os.path.join(copy, 'tasks.jsonl'), 'w', encoding='utf8') as tasks:
        tasks.write(lines.replace(shared, copy))
    return copy


def run_task(job, index, node):
    set_state(job, index, 'RUNNING', node)
    with open(job['output'].replace('%a', str(index)), 'a', encoding='utf8') as log:
        if text('bad_node') == node:
            set_state(job, index, 'NODE_FAIL', node)
            return
        if text('lost_index') == str(index):
            log.write('it smells of smoke here\n')
            set_state(job, index, 'OUT_OF_MEMORY', node)
            return
        environment = dict(os.environ, SLURM_ARRAY_TASK_ID=str(index), SLURM_JOB_ID=str(job['id']),
                           SLURMD_NODENAME=node)
        shared = os.path.dirname(os.path.dirname(job['output']))
        written = shared if text('early') is None else private_copy(shared, f'{job["id"]}_{index}')
        script = job['script'].replace(shared, written)
        code = subprocess.run(['/bin/sh', '-c', script], env=environment, stdout=log, stderr=log).returncode
    set_state(job, index, 'FAILED' if code else 'COMPLETED', node)
    if written != shared:
        wanted = count_looks() + int(text('early'))
        while count_looks() < wanted:
            time.sleep(0.05)
        for folder in 'images', 'ended':  # what has ended has its image
            for file in os.listdir(os.path.join(written, folder)):
                os.rename(os.path.join(written, folder, file), os.path.join(shared, folder, file))


def run_array(job):
    waiting = list(range(len(job['tasks'])))
    nodes = [node for node in ('na', 'nb') if node not in job['excluded']]

    def work(node):
        while True:
            while text('hold') is not None:
                time.sleep(0.05)
            with LOCK:
                if not waiting:
                    return
                index = waiting.pop(0)
            run_task(job, index, node)

    threads = [threading.Thread(target=work, args=(node,)) for node in nodes]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def sbatch(arguments):
    if text('refuse') is not None:
        sys.exit('sbatch: error: ' + text('refuse'))
    options = dict((word[2:].split('=', 1) + [''])[:2] for word in arguments)
    options['output'] = arguments[arguments.index('-o') + 1]
    excluded = options.get('exclude', '').split(',')
    if {'na', 'nb'} <= set(excluded):
        sys.exit('sbatch: error: Requested node configuration is not available')
    os.makedirs(os.path.join(ROOT, 'jobs'), exist_ok=True)
    number = len([name for name in os.listdir(os.path.join(ROOT, 'jobs')) if name.endswith('.json')]) + 1
    count = int(options['array'].split('-')[1]) + 1
    job = {'id': number, 'name': options['job-name'], 'output': options['output'], 'excluded': excluded,
           'exclusive': 'exclusive' in options, 'script': sys.stdin.read(), 'tasks': [['PENDING', '']] * count}
    save(job)
    print(number, flush=True)
    if os.fork() == 0:
        os.setsid()
        null = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(null, stream)
        run_array(job)
        os._exit(0)


def squeue(arguments):
    if text('silent') is not None:
        sys.exit('slurm_load_jobs error: Unable to contact slurm controller')
    names = [word[7:].split(',') for word in arguments if word.startswith('--name=')][0]
    for file in sorted(os.listdir(os.path.join(ROOT, 'jobs')) if os.path.isdir(os.path.join(ROOT, 'jobs')) else []):
        if not file.endswith('.json'):
            continue
        job = json.loads(text(os.path.join('jobs', file)))
        if job['name'] in names:
            for index, (state, node) in enumerate(job['tasks']):
                print(f'{job["name"]}|{index}|{state}|{node}|None|{job["id"]}_{index}')


def main():
    command = os.path.basename(sys.argv[0])
    with open(os.path.join(ROOT, 'calls.txt'), 'a', encoding='utf8') as calls:
        calls.write(' '.join([command] + sys.argv[1:]) + '\n')
    if command == 'sbatch':
        sbatch(sys.argv[1:])
    elif command == 'squeue':
        squeue(sys.argv[1:])
    elif command == 'scontrol':
        print('MaxArraySize            = 4')
    elif command == 'sacct':
        sys.exit('Slurm accounting storage is disabled')


main()
