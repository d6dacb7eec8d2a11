#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The generated tables of docs/measurements: measurements.py [ROOT]. Measures nothing. Each page's table has the rows
of its PAGE.json, in that order, with a number, a commit that the history holds, a date and a machine, or says that it
was not measured yet; each row names a
test case with that message, an experiment, or a command of the program or a benchmark with options, that the sources
have. The passes and counters that experiments read exist. The errors below the README's pictures are those of
docs/measurements/gallery.md. Prints one line per breach and exits with 1 if there is
one."""
import importlib.machinery
import importlib.util
import json
import os
import re
import subprocess
import sys

import check

TOOL = 'tools/measurements'


def load_tool():
    loader = importlib.machinery.SourceFileLoader('measurements_tool', os.path.abspath(TOOL))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


def texts(source):
    """The values of all texts of a C++ source, those of several parts joined."""
    return [''.join(re.findall(r'"((?:[^"\\\n]|\\.)*)"', match.group(0))).replace('\\"', '"')
            for match in re.finditer(r'"(?:[^"\\\n]|\\.)*"(?:\s*"(?:[^"\\\n]|\\.)*")*', source)]


class Sources:
    def __init__(self):
        self.tests = [f for f in check.tracked('.cpp') if f.startswith('tests/')]
        apps = ''.join(check.read(f) for f in check.tracked('.cpp') if f.startswith('apps/'))
        self.named = {text for f in check.tracked('.cpp') if f.startswith(('framework/', 'techniques/'))
                      for text in texts(check.read(f)) if re.fullmatch(r"[\w .']+", text)}
        self.words = {word for text in texts(apps) for word in re.findall(r'--?[a-zA-Z][\w-]*', text)}
        self.commands = set(re.findall(r'"([a-z][a-z-]*)"', apps))
        lists = ''.join(check.read(f) for f in check.tracked('CMakeLists.txt'))
        self.programs = set(re.findall(r'add_executable\((\w+)', lists))

    def faults(self, row):
        if 'test' in row:
            yield from self.test_faults(row)
        elif 'reproduce' in row:
            paper, experiment = row['reproduce'].split('/')
            if not any(f.endswith(f'/experiments/{paper}/{experiment}.json') for f in check.tracked('.json')):
                yield f'no experiment {row["reproduce"]}'
        else:
            yield from self.command_faults(row['command'])

    def test_faults(self, row):
        folder = row['test'].removeprefix('test_')
        files = [f for f in self.tests if f.endswith(f'/{row["source"]}.cpp') and f'/{folder}/' in f]
        if len(files) != 1:
            yield f'{row["test"]} has {len(files)} sources {row["source"]}.cpp'
            return
        found = texts(check.read(files[0]))
        if row['case'] not in found:
            yield f'{files[0]} has no case "{row["case"]}"'
        if not any(row['message'] in text for text in found):
            yield f'{files[0]} has no message with "{row["message"]}"'

    def command_faults(self, command):
        words = re.findall(r"[\w./=-]+", command)
        if 'lucarium' in words:
            behind = words[words.index('lucarium') + 1:]
            if behind[0] not in self.commands:
                yield f'lucarium has no command {behind[0]}'
            for word in behind:
                option = word.split('=')[0]
                if re.match(r'--?[a-zA-Z]', option) and option not in self.words:
                    yield f'lucarium has no option {option}'
        elif benches := [w for w in words if w.endswith('_bench')]:
            for name in benches:
                if name not in self.programs:
                    yield f'no program is called {name}'
        else:
            for path in (w for w in words if '/' in w and not w.startswith('/')):
                if not os.path.exists(path):
                    yield f'{path} does not exist'


def experiment_faults(file, sources):
    """Passes and counters that an experiment's values read but no source names: it would have no values."""
    names = {re.sub(r'\W', '_', text) for text in sources.named}
    for kind, name in sorted(set(re.findall(r'\b(pass|counter)_(\w+)', check.read(file)))):
        # A pass of a service may begin with its user's name: "exchange" and ".set_up".
        parts = [(name[:i], name[i:]) for i in range(1, len(name)) if name[i] == '_']
        if name not in names and not any(head in names and tail in names for head, tail in parts):
            yield f'{file}: no {kind} is called {name}'


def gallery_faults(tool):
    """Techniques and errors of the README's table that are not those of the page they are copied from."""
    rows = [[cell.strip() for cell in line.strip('|').split('|')] for line in check.read('README.md').split('\n')
            if line.startswith('|')]
    errors = next((i for i, row in enumerate(rows) if i and row[0].startswith('relMSE ')), None)
    if errors is None:
        yield 'README.md: no table has the errors of its pictures'
        return
    shown = [(name.strip('`'), error.removeprefix('relMSE ')) for name, error in zip(rows[errors - 1], rows[errors])]
    measured = re.findall(r'^\| `(\w+)[^`]*` \| \d+ \| ([\d.e-]+) \|$', check.read(f'{tool.PAGES}/gallery.md'), re.M)
    for pair in shown:
        if pair not in measured:
            yield f'README.md: {" ".join(pair)}: {tool.PAGES}/gallery.md has {measured}'


def history():
    """A function that says whether a commit is known; always true without the whole history."""
    shallow = subprocess.run(['git', 'rev-parse', '--is-shallow-repository'], capture_output=True, text=True)
    if shallow.returncode or shallow.stdout.strip() != 'false':
        return lambda commit: True
    known = subprocess.run(['git', 'rev-list', 'HEAD'], capture_output=True, text=True).stdout
    return lambda commit: f'\n{commit}' in f'\n{known}'


def breaches():
    tool, sources, holds = load_tool(), Sources(), history()
    defined = {}
    for file in check.tracked('.json'):
        if not file.startswith(tool.PAGES + '/'):
            continue
        page = os.path.basename(file).removesuffix('.json')
        text = check.read(f'{tool.PAGES}/{page}.md')
        for block, content in json.loads(check.read(file))['blocks'].items():
            defined[page, block] = file
            rows, columns = content['rows'], tool.header(content['rows'])
            for row in rows:
                for fault in sources.faults(row):
                    yield f'{file}: {block}: "{row["what"]}": {fault}'
            if any(text.count(marker) != 1 for marker in tool.markers(page, block)):
                yield f'{tool.PAGES}/{page}.md: has no block {block} ({TOOL})'
                continue
            known = tool.recorded(tool.split_page(text, page, block)[1], columns)
            if list(known) != [(row['what'], tool.command_of(row)) for row in rows]:
                yield f'{tool.PAGES}/{page}.md: the rows of {block} are not those of {file}; run {TOOL} {page} {block}'
            for (what, _), (measured, commit, date, machine) in known.items():
                if [measured, commit, date, machine] == tool.NEVER:
                    continue  # it waits for a quiet machine, and says so
                if not (measured and machine and re.fullmatch(r'20\d\d-\d\d-\d\d', date)):
                    yield f'{tool.PAGES}/{page}.md: {block}: "{what}" has no number, date or machine'
                elif not (re.fullmatch(r'[0-9a-f]{7}', commit) and holds(commit)):
                    yield f'{tool.PAGES}/{page}.md: {block}: "{what}": the history has no commit {commit}'
    yield from gallery_faults(tool)
    for file in check.tracked('.json'):
        if '/experiments/' in file:
            yield from experiment_faults(file, sources)
    for file in check.tracked('.md'):
        for page, block in re.findall(rf'<!-- generated by {TOOL} (\S+) (\S+) -->', check.read(file)):
            if (page, block) not in defined:
                yield f'{file}: {tool.PAGES}/{page}.json has no block {block}'


def main():
    os.chdir(sys.argv[1] if len(sys.argv) == 2 else os.path.join(os.path.dirname(__file__), '../..'))
    lines = list(breaches())
    print('\n'.join(lines))
    sys.exit(1 if lines else 0)


if __name__ == '__main__':
    main()
