#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""figure.py RESULTS FIGURE: reads RESULTS/results.json of a comparison (docs/results.md) with pandas and draws error
over time, one panel a scene: relMSE, geometric mean over seeds with its 95 % interval, on logarithmic axes. Below the
grey line the reference's own error is more than a tenth of what is drawn. Where machines were unlike, time is that of
processors. The ending of FIGURE chooses the format (.pdf, .svg, .png). Prints the tables of the text: the error at the
end of each budget, and how many times that of the first technique it is, paired by seeds. Needs pandas, scipy,
matplotlib."""
import json
import pathlib
import sys

import matplotlib
import numpy as np
import pandas as pd
from scipy.stats import t

matplotlib.use('Agg')
matplotlib.rcParams['svg.hashsalt'] = 'lucarium'  # the same results, the same file
import matplotlib.pyplot as plt

RUN = ['scene', 'variant', 'budget']


def read(folder):
    results = json.loads((pathlib.Path(folder) / 'results.json').read_text(encoding='utf8'))
    if results['schema'] != 'lucarium-results-2':
        sys.exit(f'{folder}/results.json has the schema {results["schema"]}, which this script does not know')
    return results


def named(table, results):
    """Indices replaced by the names they stand for."""
    for column, entries, name in ('scene', 'scenes', 'name'), ('variant', 'variants', 'label'), (
            'budget', 'budgets', 'label'):
        table[column] = table[column].map([entry[name] for entry in results[entries]].__getitem__)
    return table


def time_of(results):
    """The column of the horizontal axis: what pieces cost by the clock compares machines where they are unlike."""
    return 'processor_seconds' if any(scene.get('unlike_machines') for scene in results['scenes']) else 'seconds'


def curve(runs):
    """Geometric mean and interval of the relMSE of runs that differ in their seeds alone, at times that all of them
    cover, half an octave apart. Between its snapshots the error of a run is a power of time."""
    first = max(run['seconds'].min() for run in runs)
    last = min(run['seconds'].max() for run in runs)
    if last <= first:
        return pd.DataFrame()
    seconds = np.geomspace(first, last, 2 + int(2 * np.log2(last / first)))
    logs = np.array([np.interp(np.log(seconds), np.log(run['seconds']), np.log(run['metrics.relMSE'])) for run in runs])
    mean, count = logs.mean(axis=0), len(runs)
    half = t.ppf(0.975, count - 1) * logs.std(axis=0, ddof=1) / count**0.5 if count > 1 else np.nan
    return pd.DataFrame({'seconds': seconds, 'relmse': np.exp(mean), 'low': np.exp(mean - half),
                         'high': np.exp(mean + half)})


def curves(results):
    """One row a point: scene, variant, budget, seconds, relmse, low, high. Nothing of runs of which a seed has no such
    time, as on a GPU."""
    pieces = [piece for piece in results['pieces'] if 'failure' not in piece]
    snapshots = pd.json_normalize(pieces, 'snapshots', RUN + ['seed'])
    if time_of(results) not in snapshots:
        snapshots[time_of(results)] = np.nan
    timed = snapshots.dropna(subset=[time_of(results)])
    timed = timed.assign(seconds=timed[time_of(results)].astype(float)).sort_values('seconds')
    seeds = snapshots.groupby(RUN)['seed'].nunique()
    tables = []
    for key, group in timed.groupby(RUN):
        if group['seed'].nunique() < seeds[key]:
            continue
        tables.append(curve([run for _, run in group.groupby('seed')]).assign(**dict(zip(RUN, key))))
    if not tables:
        sys.exit('the machines are unlike, and their processor times are not known: there is no time to draw')
    return named(pd.concat(tables), results)


def ends(results):
    """One row a scene, variant and budget: relMSE at the end, its interval, whether the reference resolves it."""
    rows = pd.json_normalize(results['summaries'])
    rows = rows.rename(columns={f'metrics.relMSE.{key}': name for key, name in (
        ('mean', 'relmse'), ('low', 'low'), ('high', 'high'))})
    return named(rows.reindex(columns=RUN + ['seeds', 'relmse', 'low', 'high', 'resolved']), results)


def ratios(results):
    """One row a scene, variant and budget: relMSE over that of the first technique, paired by seeds, its interval, and
    whether that leaves out 1."""
    pairs = [pair for pair in results['pairs'] if pair['metric'] == 'relMSE' and pair['a'] == 0]
    if not pairs:
        return pd.DataFrame(columns=RUN + ['ratio'])
    rows = pd.json_normalize(pairs).rename(columns={'b': 'variant'})
    # The file holds a over b; of the inverse the bounds change places.
    rows['ratio'], rows['low'], rows['high'] = (1 / rows[f'ratio.{key}'] for key in ('mean', 'high', 'low'))
    return named(rows[RUN + ['ratio', 'low', 'high', 'different']].copy(), results)


def draw(table, results, file):
    scenes = [scene for scene in results['scenes'] if 'failure' not in scene]
    figure, panels = plt.subplots(1, len(scenes), figsize=(3 * len(scenes) + 1.4, 2.8), sharey=True, squeeze=False,
                                  constrained_layout=True)
    unit = 's' if time_of(results) == 'seconds' else 'processor s'
    for panel, scene in zip(panels[0], scenes):
        for index, variant in enumerate(entry['label'] for entry in results['variants']):
            rows = table[(table['scene'] == scene['name']) & (table['variant'] == variant)]
            for _, run in rows.groupby('budget'):
                panel.plot(run['seconds'], run['relmse'], color=f'C{index}', label=variant, marker='.', lw=1.2)
                panel.fill_between(run['seconds'], run['low'], run['high'], color=f'C{index}', alpha=0.2, lw=0)
        own = max((one['own_relmse'] for one in scene['references'] if 'own_relmse' in one), default=0)
        if own > 0:
            panel.axhline(10 * own, color='grey', lw=0.8, ls='--')
        panel.set(xscale='log', yscale='log', xlabel=f'preparing and iterating [{unit}]', title=scene['name'])
        panel.grid(lw=0.3)
    panels[0][0].set_ylabel('relMSE')
    panels[0][-1].legend(fontsize='small', loc='center left', bbox_to_anchor=(1, 0.5))
    undated = {'.svg': {'Date': None}, '.pdf': {'CreationDate': None}}
    figure.savefig(file, dpi=200, metadata=undated.get(pathlib.Path(file).suffix))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    results = read(sys.argv[1])
    draw(curves(results), results, sys.argv[2])
    for table in ends(results), ratios(results):
        print(table.to_string(index=False, float_format='{:.3g}'.format), end='\n\n')


if __name__ == '__main__':
    main()
