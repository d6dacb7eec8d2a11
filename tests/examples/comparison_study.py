#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""comparison_study.py STEP PROGRAM STUDY RESULTS, of docs/examples/comparison_study:
  run     runs STUDY/study.json, with nothing changed but sizes, and writes RESULTS
  figure  draws RESULTS with STUDY/figure.py, and results whose curves are powers of time, of which the figure's means
          and intervals are known; 77, skipped, where no Python with pandas, scipy and matplotlib is found"""
import importlib.util
import json
import math
import os
import pathlib
import re
import subprocess
import sys

SIZES = {'budgets': [{'iterations': 2}], 'seeds': 2, 'size': [16, 9], 'reference': {'samples': 32}}
# What keeps the preparing of techniques short.
COARSE = {'bundle_exchange': {'texels': 1024, 'access_rays': 128},
          'micro_rendering': {'points_log2': 12, 'micro_size': 8}}
# The 97.5 % quantile of Student's t with two degrees of freedom: 0.95 sqrt(2 / (1 - 0.95²)).
T_2 = 0.95 * math.sqrt(2 / (1 - 0.95**2))


def fail(what):
    sys.exit(f'failed: {what}')


def run(program, study, results):
    text = (study / 'study.json').read_text(encoding='utf8')
    asked = json.loads(re.sub(r'^\s*//.*$', '', text, flags=re.M))
    if not set(SIZES) <= set(asked):
        fail(f'the study does not say {sorted(set(SIZES) - set(asked))}')
    techniques = [{'technique': name, 'parameters': COARSE[name], 'name': name} if name in COARSE else name
                  for name in asked['techniques']]
    results.mkdir(parents=True, exist_ok=True)
    small = results / 'small.json'
    small.write_text(json.dumps({**asked, **SIZES, 'techniques': techniques}), encoding='utf8')
    subprocess.run([program, 'compare', '--quiet', '--comparison', small, '-o', results / 'results', '--overwrite'],
                   check=True)
    found = json.loads((results / 'results/results.json').read_text(encoding='utf8'))
    expected = len(asked['scenes']) * len(techniques) * SIZES['seeds']
    finished = sum('failure' not in piece for piece in found['pieces'])
    if finished != expected:
        fail(f'{finished} of {expected} runs finished')


def power_laws():
    """results.json of two techniques and three seeds: relMSE 0.01 f / t and 0.1 f / t², f of the seed, begun and ended
    at other times by each seed."""
    factors, pieces = (0.5, 1.0, 2.0), []
    for variant, (scale, power) in enumerate(((0.01, 1), (0.1, 2))):
        for seed, factor in enumerate(factors, 1):
            times = [0.1 * seed * 2**(i / 2) for i in range(9)]
            snapshots = [{'seconds': s, 'processor_seconds': 2 * s, 'metrics': {'relMSE': scale * factor * s**-power}}
                         for s in times]
            pieces.append({'scene': 0, 'variant': variant, 'budget': 0, 'seed': seed, 'snapshots': snapshots})
    pieces.append({'scene': 0, 'variant': 1, 'budget': 0, 'seed': 4, 'failure': 'it crashed'})
    mean = {'mean': 2.0, 'low': 1.0, 'high': 4.0}
    return {'schema': 'lucarium-results-2', 'variants': [{'label': 'one'}, {'label': 'two'}],
            'budgets': [{'label': '2 s'}], 'scenes': [{'name': 'box', 'references': [{'own_relmse': 1e-5}]}],
            'pieces': pieces,
            'summaries': [{'scene': 0, 'variant': v, 'budget': 0, 'seeds': 3, 'resolved': True,
                           'metrics': {'relMSE': mean}} for v in (0, 1)],
            'pairs': [{'scene': 0, 'budget': 0, 'a': 0, 'b': 1, 'metric': 'relMSE', 'ratio': mean, 'different': True}]}


def near(what, value, expected):
    if not math.isclose(value, expected, rel_tol=1e-9):
        fail(f'{what} is {value}, not {expected}')


def check_power_laws(figure, folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / 'results.json').write_text(json.dumps(power_laws()), encoding='utf8')
    results = figure.read(folder)
    table = figure.curves(results)
    # ln f is -ln 2, 0, ln 2: mean 0, standard deviation ln 2.
    spread = math.exp(T_2 * math.log(2) / math.sqrt(3))
    for variant, scale, power in ('one', 0.01, 1), ('two', 0.1, 2):
        rows = table[table['variant'] == variant]
        near(f'the first time of {variant}', rows['seconds'].min(), 0.3)  # of the seed that begins last
        near(f'the last time of {variant}', rows['seconds'].max(), 1.6)  # of the seed that ends first
        for row in rows.itertuples():
            exact = scale * row.seconds**-power
            near(f'relMSE of {variant}', row.relmse, exact)
            near(f'its lower bound of {variant}', row.low, exact / spread)
            near(f'its upper bound of {variant}', row.high, exact * spread)
    ratio = figure.ratios(results).iloc[0]
    for name, expected in ('ratio', 0.5), ('low', 0.25), ('high', 1.0):
        near(name, ratio[name], expected)
    if ratio['variant'] != 'two' or list(figure.ends(results)['relmse']) != [2.0, 2.0]:
        fail('the tables name other techniques or errors')


def forget_processors(piece):
    for snapshot in piece.get('snapshots', []):
        snapshot.pop('processor_seconds', None)


def check_unlike_machines(figure):
    """There time is that of processors, or nothing is drawn."""
    results = power_laws()
    results['scenes'][0]['unlike_machines'] = True
    rows = figure.curves(results)
    rows = rows[rows['variant'] == 'two']
    near('the first processor time', rows['seconds'].min(), 0.6)
    for row in rows.itertuples():
        near('relMSE over processor time', row.relmse, 0.1 * (row.seconds / 2)**-2)
    forget_processors(results['pieces'][0])  # as one that ran on a GPU
    if set(figure.curves(results)['variant']) != {'two'}:
        fail('a technique of which a seed has no processor time was drawn, or the other was not')
    for piece in results['pieces']:
        forget_processors(piece)
    try:
        figure.curves(results)
    except SystemExit:
        return
    fail('wall times of unlike machines were drawn')


def check_drawing(figure, study, folder):
    """The script as it is called; the same results give the same bytes."""
    pictures = []
    for name in 'first.svg', 'second.svg':
        subprocess.run([sys.executable, study / 'figure.py', folder, folder / name], check=True, capture_output=True)
        pictures.append((folder / name).read_bytes())
    if pictures[0] != pictures[1]:
        fail('the same results give another figure')
    # Above all the lines of the techniques, in matplotlib's first colors.
    colors = set(re.findall(r'stroke: (#\w+)', pictures[0].decode()))
    wanted = ['#1f77b4', '#ff7f0e', '#2ca02c', '#d62728'][:len(figure.read(folder)['variants'])]
    if not set(wanted) <= colors:
        fail(f'the figure has lines in {sorted(colors)}, not in {wanted}')


def needs(python):
    return subprocess.run([python, '-c', 'import pandas, scipy, matplotlib'], capture_output=True).returncode == 0


def figure(study, results):
    if not needs(sys.executable):
        if sys.executable != '/usr/bin/python3' and os.path.exists('/usr/bin/python3') and needs('/usr/bin/python3'):
            os.execv('/usr/bin/python3', ['/usr/bin/python3', *sys.argv])
        print('Skipped: no Python with pandas, scipy and matplotlib (Debian: python3-pandas python3-scipy '
              'python3-matplotlib)')
        sys.exit(77)
    sys.dont_write_bytecode = True  # pages are installed as they lie
    spec = importlib.util.spec_from_file_location('figure', study / 'figure.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    check_power_laws(module, results / 'power_laws')
    check_unlike_machines(module)
    check_drawing(module, study, results / 'power_laws')
    subprocess.run([sys.executable, study / 'figure.py', results / 'results', results / 'study.svg'], check=True)


def main():
    step, program, study, results = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3]), pathlib.Path(sys.argv[4])
    if step == 'run':
        run(program, study, results)
    else:
        figure(study, results)


main()
