#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Comparisons on a real Slurm: slurm_test.py PROGRAM. Daemons and the program are killed, a node fails everything, the
disk is full. Exits with 77 where there can be no cluster."""
import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

import cluster as slurm

PROGRAM = sys.argv[1]
SEEDS = 100  # of two techniques
FAILURES = []


def check(holds, what):
    print('ok' if holds else 'FAILED', what, flush=True)
    if not holds:
        FAILURES.append(what)


def comparison(folder, seeds, *more):
    return [PROGRAM, 'compare', 'builtin:cornell', '-t', 'path_tracing', '-t', 'path_tracing:estimator=nee',
            '--size', '32x24', '--max-bounces', '1', '--iterations', '1', '--seeds', str(seeds),
            '--reference-spp', '32', '--cache-dir', str(folder.parent / 'cache'), '-o', str(folder), *more]


def finished(folder):
    """Summary and image of every piece, by name."""
    files = {}
    for summary in (folder / 'pieces').glob('scene*.json'):
        files[summary.name] = summary.read_bytes()
        files[summary.stem + '.exr'] = summary.with_suffix('.exr').read_bytes()
    return files


def results(folder):
    return json.loads((folder / 'results.json').read_text())


def start(folder, *more):
    with open(folder.parent / (folder.name + '.log'), 'ab') as log:
        return subprocess.Popen(comparison(folder, SEEDS, '--executor', 'slurm', *more), stderr=log, stdout=log)


def wait_for_pieces(client, folder, count):
    while client.poll() is None and len(list((folder / 'pieces').glob('scene*.json'))) < count:
        time.sleep(0.1)
    check(client.poll() is None, f'the program still waits when {count} pieces are there')


def kill_everything(cluster, work):
    """200 pieces; a node daemon, the controller and the program are killed on the way."""
    folder = work / 'killed'
    client = start(folder)
    wait_for_pieces(client, folder, 20)
    cluster.kill('nb')
    wait_for_pieces(client, folder, 40)
    cluster.kill('slurmctld')
    time.sleep(3)
    cluster.start('slurmctld')
    cluster.start('nb')
    wait_for_pieces(client, folder, 60)
    before = finished(folder)
    client.send_signal(signal.SIGKILL)
    client.wait()
    check(len(cluster.call('squeue', '--noheader')) > 0, 'the jobs outlive the program')
    client = start(folder, '--resume')
    wait_for_pieces(client, folder, 80)
    client.send_signal(signal.SIGINT)
    check(client.wait() == 6, 'Ctrl-C ends the program as interrupted')
    client = start(folder, '--resume')
    check(client.wait() == 0, 'after --resume it ends well')
    log = (work / 'killed.log').read_text()
    check('go on; --resume attaches' in log, 'Ctrl-C says that the jobs go on')
    check('attached to' in log, '--resume attaches to jobs')
    after = finished(folder)
    check(len(after) == 4 * SEEDS, f'{2 * SEEDS} pieces are there ({len(after) // 2})')
    check(all(after[name] == content for name, content in before.items()), 'what was finished stays byte for byte')
    check(not any('failure' in piece for piece in results(folder)['pieces']), 'none has failed')
    check(not (folder / 'slurm').exists(), 'nothing of Slurm is left in the folder')
    alone = work / 'alone'
    subprocess.run(comparison(alone, 3), check=True, capture_output=True)
    for image in (alone / 'pieces').glob('*.exr'):
        check(same_pixels(folder / 'pieces' / image.name, image), f'{image.name} has the pixels of this machine')


def same_pixels(a, b):
    return subprocess.run([PROGRAM, 'diff', a, b, '--max-relmse', '1e-300', '-q'], capture_output=True).returncode == 0


def references(cluster, work):
    """Rounds of a reference as arrays; an interrupt on the way."""
    alone, arrays = work / 'alone.exr', work / 'arrays.exr'
    command = [PROGRAM, 'reference', 'builtin:cornell', '--size', '32x24', '--max-bounces', '1', '-q']
    for goal in ['--spp', '1024'], ['--relmse', '0.002']:
        for file, more in (alone, []), (arrays, ['--executor', 'slurm']):
            run = subprocess.run([*command, *goal, *more, '-o', file, '--overwrite'], capture_output=True, text=True)
            check(run.returncode == 0, f'{goal} {more}: {run.stderr[-300:]}')
        check(same_pixels(arrays, alone), f'{goal}: the file of this machine')
    subprocess.run([*command, '--spp', '4096', '-o', alone, '--overwrite'], check=True, capture_output=True)
    client = subprocess.Popen([*command, '--spp', '4096', '-o', arrays, '--overwrite', '--executor', 'slurm'])
    cluster.wait_for(lambda: cluster.call('squeue', '--noheader', '--states=RUNNING'))
    client.send_signal(signal.SIGINT)
    check(client.wait() == 6, 'Ctrl-C ends the reference as interrupted')
    run = subprocess.run([*command, '--spp', '4096', '-o', arrays, '--extend', '--executor', 'slurm'],
                         capture_output=True, text=True)
    check(run.returncode == 0, f'--extend goes on: {run.stderr[-300:]}')
    check(same_pixels(arrays, alone), 'and ends with the file of this machine')
    check(not (work / 'arrays.exr.rounds').exists(), 'nothing is left beside it')


def papers(cluster, work):
    paper = work / 'papers/experiments/author2026'
    paper.mkdir(parents=True)
    (paper / 'paper.json').write_text(json.dumps({
        'schema': 'lucarium-paper-1', 'citation': 'Author 2026', 'technique': 'path_tracing',
        'experiments': ['errors']}))
    (paper / 'errors.json').write_text(json.dumps({
        'schema': 'lucarium-experiment-1', 'title': 'Errors', 'place': 'Table 1', 'claim': 'None.',
        'comparison': {
            'scenes': ['builtin:cornell'], 'budgets': [{'iterations': 2}], 'seeds': 2, 'size': [32, 24],
            'techniques': ['path_tracing', {'technique': 'path_tracing', 'parameters': {'estimator': 'nee'},
                                            'name': 'nee'}],
            'max_bounces': 1, 'reference': {'samples': 32}},
        'quick': {'seeds': 1},
        'values': [{'name': 'error', 'technique': 'nee', 'value': 'relMSE'}],
        'trends': [{'claim': 'there is one', 'holds': 'error > 0'}]}))
    for name, more in ('alone', []), ('arrays', ['--executor', 'slurm']):
        run = subprocess.run([PROGRAM, 'reproduce', 'author2026/errors', '--full', '--technique-path', work / 'papers',
                              '--cache-dir', work / f'cache of {name}', '-o', work / f'paper {name}', *more],
                             capture_output=True, text=True)
        check(run.returncode == 0, f'reproduce {more}: {run.stderr[-300:]}')
    images = list((work / 'paper alone/errors/pieces').glob('*.exr'))
    check(len(images) == 4, 'an experiment has four pieces')
    for image in images:
        check(same_pixels(work / 'paper arrays/errors/pieces' / image.name, image), f'{image.name} of the experiment')


def failing_node(cluster, work):
    (cluster.root / 'bad').write_text('na\n')
    folder = work / 'failing'
    run = subprocess.run(comparison(folder, 3, '--executor', 'slurm'), capture_output=True, text=True, timeout=300)
    check(run.returncode == 0, f'a node that fails everything loses no piece: {run.stderr[-300:]}')
    check(len(results(folder)['pieces']) == 6, 'all six are there')
    (cluster.root / 'bad').unlink()
    cluster.call('scontrol', 'update', 'nodename=na', 'state=resume')


def full_disk(cluster, work):
    small = work / 'small'
    small.mkdir()
    subprocess.run(['mount', '-t', 'tmpfs', '-o', 'size=8M', 'tmpfs', small], check=True)
    try:
        folder = small / 'results'
        subprocess.run(comparison(folder, 1, '--executor', 'slurm'), check=True, capture_output=True)
        before = finished(folder)
        (folder / 'pieces/scene1-variant1-budget1-seed1.json').unlink()
        with open(small / 'ballast', 'wb', buffering=0) as ballast:
            try:
                while True:
                    ballast.write(bytes(4096))
            except OSError:
                pass
        run = subprocess.run(comparison(folder, 1, '--executor', 'slurm', '--resume'), capture_output=True, text=True)
        check(run.returncode != 0, f'a full disk is reported: {run.stderr[-200:]}')
        (small / 'ballast').unlink()
        run = subprocess.run(comparison(folder, 1, '--executor', 'slurm', '--resume'), capture_output=True, text=True)
        check(run.returncode == 0, f'with room again it ends well: {run.stderr[-200:]}')
        kept = 'scene1-variant2-budget1-seed1.exr'
        check(finished(folder)[kept] == before[kept], 'what was finished stays byte for byte')
        check(len(finished(folder)) == 4, 'all pieces are there')
    finally:
        subprocess.run(['umount', '-l', small], check=False)


def main():
    reason = slurm.missing()
    if reason:
        print('skipped:', reason)
        sys.exit(77)
    with tempfile.TemporaryDirectory(prefix='lucarium-slurm-') as root:
        work = pathlib.Path(root) / 'work'
        work.mkdir()
        cluster = slurm.Cluster(pathlib.Path(root) / 'cluster')
        try:
            for part in references, papers, failing_node, full_disk, kill_everything:
                if len(sys.argv) < 3 or part.__name__ in sys.argv[2:]:
                    print(part.__name__, flush=True)
                    part(cluster, work)
        finally:
            cluster.stop()
            if FAILURES:
                for log in work.glob('*.log'):
                    print(log.read_text()[-2000:])
    sys.exit(1 if FAILURES else 0)


main()
