#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a comparison of 6000 pieces costs before and after they are rendered: many_pieces.py plan|read [SCENES [SEEDS]]

20 scenes (all of them builtin:cornell), 6 variants, 5 budgets of iterations, 10 seeds, at 32×24 pixels; in the current
folder, with `lucarium` in PATH.
  plan  a script in place of sbatch takes the arrays and runs nothing: seconds from the start of the program to the last
        array, without the time of the references
  read  all pieces are there (copies of one that was rendered); compare --resume reads them and writes results and
        report: seconds, peak memory of the program, files by folder"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

VARIANTS = [{}, {'estimator': 'nee'}, {'estimator': 'bsdf'}, {'estimator': 'balance'}, {'light_choice': 'uniform'},
            {'sampler': 'random'}]  # of the same light: one reference serves all
# Takes everything; all tasks wait for ever.
SLURM = '''#!/usr/bin/env python3
import pathlib, sys, time
name, root = pathlib.Path(sys.argv[0]).name, pathlib.Path(sys.argv[0]).parent
words = dict(word[2:].split('=', 1) for word in sys.argv[1:] if word.startswith('--') and '=' in word)
if name == 'sbatch':
    with open(root / 'arrays', 'a') as arrays:
        print(time.time(), words['job-name'], words['array'].split('-')[1], file=arrays)
elif name == 'squeue' and (root / 'arrays').exists():
    for number, line in enumerate((root / 'arrays').read_text().splitlines()):
        _, job, last = line.split()
        if job in words['name'].split(','):
            for index in range(int(last) + 1):
                print(f'{job}|{index}|PENDING||Priority|{number}_{index}')
elif name == 'scontrol':
    print('MaxArraySize            = 1001')
'''


def compare(*more):
    return ['lucarium', 'compare', '--comparison', 'study.json', '-o', 'results', '--cache-dir', 'cache', *more]


def write_study(scenes, seeds):
    techniques = [{'technique': 'path_tracing', 'parameters': parameters, 'name': f'variant {i + 1}'}
                  for i, parameters in enumerate(VARIANTS)]
    study = {'schema': 'lucarium-comparison-1', 'techniques': techniques, 'seeds': seeds, 'size': [32, 24],
             'scenes': [{'scene': 'builtin:cornell', 'name': f'scene {i + 1}'} for i in range(scenes)],
             'budgets': [{'iterations': i + 1} for i in range(5)], 'max_bounces': 1, 'reference': {'samples': 32}}
    pathlib.Path('study.json').write_text(json.dumps(study))
    return scenes * len(techniques) * 5 * seeds


def begin():
    """Renders the references and a first piece of every variant."""
    pieces = pathlib.Path('results/pieces')
    client = subprocess.Popen(compare('-q'), stdout=subprocess.DEVNULL)
    while client.poll() is None and len(list(pieces.glob('*.json'))) < len(VARIANTS):
        time.sleep(0.1)
    client.send_signal(signal.SIGINT)
    if client.wait() != 6:
        sys.exit(f'the beginning ended with {client.returncode}')


def plan(pieces):
    left = pieces - len(list(pathlib.Path('results/pieces').glob('*.json')))
    tools = pathlib.Path('slurm tools').absolute()
    tools.mkdir()
    for name in 'sbatch', 'squeue', 'sacct', 'scancel', 'scontrol':
        (tools / name).write_text(SLURM)
        (tools / name).chmod(0o755)
    arrays = tools / 'arrays'

    def submitted():
        return [line.split() for line in arrays.read_text().splitlines()] if arrays.exists() else []

    begun = time.time()
    client = subprocess.Popen(compare('--resume', '--executor', 'slurm', '-q'),
                              stdout=subprocess.DEVNULL, env={**os.environ, 'PATH': f'{tools}:{os.environ["PATH"]}'})
    while client.poll() is None and sum(int(last) + 1 for _, _, last in submitted()) < left:
        time.sleep(0.1)
    client.send_signal(signal.SIGINT)
    if client.wait() != 6:
        sys.exit(f'planning ended with {client.returncode}')
    times = [float(moment) for moment, _, _ in submitted()]
    print(f'{left} tasks in {len(times)} arrays, the first after {times[0] - begun:.1f} s, '
          f'the last after {times[-1] - begun:.1f} s')


def copy_pieces(pieces):
    """The first piece of each variant stands for all of its scenes, budgets and seeds."""
    folder = pathlib.Path('results/pieces')
    study = json.loads(pathlib.Path('study.json').read_text())
    for scene in range(len(study['scenes'])):
        for variant in range(len(VARIANTS)):
            for budget in range(5):
                for seed in range(study['seeds']):
                    name = f'scene{scene + 1}-variant{variant + 1}-budget{budget + 1}-seed{seed + 1}'
                    if (folder / f'{name}.json').exists():
                        continue
                    for kind in 'exr', 'json':
                        shutil.copy(folder / f'scene1-variant{variant + 1}-budget1-seed1.{kind}',
                                    folder / f'{name}.{kind}')
    if len(list(folder.glob('*.json'))) != pieces:
        sys.exit('there are not as many pieces as there should be')


def read(pieces):
    copy_pieces(pieces)
    begun = time.time()
    with open('log.txt', 'w', encoding='utf8') as log:
        run = subprocess.Popen(compare('--resume'), stdout=log, stderr=log)
        _, status, usage = os.wait4(run.pid, 0)
    seconds = time.time() - begun
    log = pathlib.Path('log.txt').read_text()
    if status != 0 or f'finished already: {pieces} pieces' not in log:
        sys.exit(log[-2000:])
    results = json.loads(pathlib.Path('results/results.json').read_text())
    if len(results['pieces']) != pieces or any('failure' in piece for piece in results['pieces']):
        sys.exit('pieces have failed')
    files = {}
    for path in pathlib.Path('results').rglob('*'):
        if path.is_file():
            count, size = files.get(path.parent.name, (0, 0))
            files[path.parent.name] = count + 1, size + path.stat().st_size
    listed = ', '.join(f'{name}: {count} ({size / 1e6:.0f} MB)' for name, (count, size) in sorted(files.items()))
    print(f'{pieces} pieces read in {seconds:.1f} s with {usage.ru_maxrss / 1024:.0f} MB at most; files in {listed}')


def main():
    what, *numbers = sys.argv[1:] or ['']
    if what not in ('plan', 'read') or len(numbers) > 2:
        sys.exit(__doc__)
    scenes, seeds = [*map(int, numbers), 20, 10][:2] if len(numbers) != 1 else (int(numbers[0]), 10)
    pieces = write_study(scenes, seeds)
    begin()
    {'plan': plan, 'read': read}[what](pieces)


main()
