#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Rules of the sources that a compiler does not check: check.py RULE [ROOT], where RULE is one of
  format    clang-format would change nothing
  width     no line is wider than 120 columns (tables and code blocks of pages excepted)
  folders   folders include each other in one direction, and in the order of ORDER
  options   no string of the library is an option of the program: it starts it with a job file
  dialect   a kernel file writes address spaces as __global, or as global, not both
  headers   a source of the library or the program without a header of its name says in its first comment which header
            declares what it defines
  approx    tests take tolerances of tests/support/tolerance.h, not doctest's Approx: its epsilon is absolute below one
  links     every relative link of a page and every path of a file or folder that a page or comment names exists
  pages     pages but those of measurements have at most 5 numbers in 100 words of their sentences; a technique's page
            has at most 120 lines
  citations every section, equation, figure, table and algorithm of a paper of CITATIONS that the sources cite is in
            that list, in full words ("section 2.3", "equation 4") so that a search finds it, beside which the head of
            the technique may have "Eq. 4"; what the list calls cited is cited at the code too; "FILE: function()" in
            comments names what exists
  mutants   the text that each planted fault of tests/mutation replaces occurs exactly once, and its test is listed;
            each list has one for the quick set; every kernel file has a planted fault, or stands in UNPLANTED with the
            reason why no fault of it shows
Prints one line per breach and exits with 1 if there is one, with 77 if the tool that it needs is absent."""
import collections
import json
import os
import re
import shutil
import subprocess
import sys

WIDTH = 120
SOURCES = ('.cpp', '.h', '.cl', '.clh')
TEXTS = SOURCES + ('.md', '.txt', '.cmake', '.py', '.js', '.css', '.html')
# Comparison files state the device in these words, whatever the program's options are called; and options of sbatch.
WORDS_OF_FILES = ('framework/lucarium/compare/request/device_arguments.cpp',
                  'framework/lucarium/compare/execute/slurm_commands.cpp')
ROOTS = ('framework', 'kernels', 'techniques', 'apps/lucarium')  # of include names
OPTION_TEXTS = 'apps/lucarium/grammar/option_texts.cpp'
MEASUREMENTS = 'docs/measurements/'
NUMBERS = 5  # in 100 words of a page's sentences
TECHNIQUE_LINES = 120
CITATIONS = 'tests/style/citations.json'
UNPLANTED = 'tests/style/unplanted.json'  # kernel file: reason
# By `lucarium techniques --markdown` and `lucarium commands --markdown`, from texts that are checked where they stand.
GENERATED = ('docs/techniques.md', 'docs/command_line.md')

# Each folder may include those before it.
ORDER = ['kernels/lucarium'] + ['framework/lucarium/' + folder for folder in (
    'base', 'compute', 'film', 'scene', 'services', 'technique', 'session', 'job', 'metrics', 'statistics', 'compare',
    'view', 'conformance')] + ['techniques', 'apps']


def tracked(endings):
    """Files under version control, or, where this is no checkout, all of them outside build folders."""
    listing = subprocess.run(['git', 'ls-files', '-z'], capture_output=True, text=True)
    if listing.returncode == 0:
        files = listing.stdout.split('\0')[:-1]
    else:
        files = [os.path.relpath(os.path.join(folder, name), '.') for folder, _, names in os.walk('.')
                 if not re.match(r'\./(build|results|\.git)', folder) for name in names]
    return [f for f in files if f.endswith(endings) and os.path.exists(f)]


def read(path):
    with open(path, encoding='utf8') as file:
        return file.read()


def check_format():
    tool = shutil.which('clang-format-14') or shutil.which('clang-format')
    if not tool:
        print('skipped: clang-format is not installed')
        sys.exit(77)
    run = subprocess.run([tool, '--dry-run', '--Werror', *tracked(SOURCES)], capture_output=True, text=True)
    for file in sorted(set(re.findall(r'^(.+?):\d+:\d+: error:', run.stderr, re.M))):
        yield f'{file}: clang-format would change it ({os.path.basename(tool)} -i {file})'


def check_width():
    for file in tracked(TEXTS):
        if file in GENERATED:
            continue
        text = read(file)
        for number, line in page_lines(text) if file.endswith('.md') else enumerate(text.split('\n'), 1):
            if len(line) > WIDTH:
                yield f'{file}:{number}: {len(line)} columns'


def page_lines(text):
    """(number, line) of a page, without tables and code blocks."""
    code = False
    for number, line in enumerate(text.split('\n'), 1):
        fence = line.lstrip().startswith('```')
        code ^= fence
        if not (code or fence or line.lstrip().startswith('|') or line.startswith('    ')):
            yield number, line


def check_pages():
    for file in tracked('.md'):
        text = read(file)
        lines = text.count('\n')
        if re.fullmatch(r'docs/techniques/\w+\.md', file) and lines > TECHNIQUE_LINES:
            yield f'{file}: {lines} lines, more than {TECHNIQUE_LINES}: measurements go to {MEASUREMENTS}'
        if file in GENERATED or file.startswith(MEASUREMENTS):
            continue
        sentences = '\n'.join(line for _, line in page_lines(text))
        sentences = re.sub(r'\]\([^)]*\)', ']', re.sub(r'`[^`]*`', 'code', sentences))
        words, numbers = len(sentences.split()), len(re.findall(r'(?<![\w.])\d', sentences))
        if 100 * numbers > NUMBERS * words:
            yield f'{file}: {numbers} numbers in {words} words: they go to {MEASUREMENTS}, or into a table'


def included(file, name):
    """The file that an include means: beside the including one, or below a root."""
    for path in [os.path.join(os.path.dirname(file), name)] + [os.path.join(root, name) for root in ROOTS]:
        if os.path.exists(path):
            return os.path.normpath(path)
    return None


def place(folder):
    """Where a folder stands in ORDER."""
    ranks = [i for i, known in enumerate(ORDER) if folder == known or folder.startswith(known + '/')]
    return ranks[0] if ranks else None


def check_options():
    declared = set()
    for names in re.findall(r'^    \{"(-[^"]+)"', read(OPTION_TEXTS), re.M):
        declared.update(names.split(','))
    if '--output' not in declared:
        yield f'{OPTION_TEXTS}: no options are found in it'
    for file in tracked(SOURCES):
        if not file.startswith('framework/') or file in WORDS_OF_FILES:
            continue
        for number, line in enumerate(read(file).split('\n'), 1):
            for word in re.findall(r'"(--?[a-z][a-z-]*)=?(?:\{\})?"', line):
                if word in declared:
                    yield f'{file}:{number}: {word} is an option of the program (framework/lucarium/job)'


def circles(edges):
    """Strongly connected components of more than one folder (Tarjan 1972)."""
    index, low, stack, found = {}, {}, [], []

    def visit(v):
        index[v] = low[v] = len(index)
        stack.append(v)
        for w in edges.get(v, ()):
            if w not in index:
                visit(w)
                low[v] = min(low[v], low[w])
            elif w in stack:
                low[v] = min(low[v], index[w])
        if low[v] == index[v]:
            at = stack.index(v)
            component = stack[at:]
            del stack[at:]
            if len(component) > 1:
                found.append(sorted(component))

    for v in list(edges):
        if v not in index:
            visit(v)
    return found


def check_folders():
    edges = collections.defaultdict(dict)
    for file in tracked(SOURCES):
        folder = os.path.dirname(file)
        if place(folder) is None:
            continue
        for name in re.findall(r'^\s*#include\s+"([^"]+)"', read(file), re.M):
            target = included(file, name)
            if not target:
                if name != 'lucarium/version.h':
                    yield f'{file}: "{name}" lies in no root ({", ".join(ROOTS)})'
                continue
            other = os.path.dirname(target)
            if other == folder:
                continue
            edges[folder].setdefault(other, f'{file} includes {target}')
            if place(other) is None or place(other) > place(folder):
                yield f'{file}: includes upwards: {target}'
            mine, theirs = folder.split('/'), other.split('/')
            if mine[0] == theirs[0] == 'techniques' and mine[1] != theirs[1]:
                yield f'{file}: a technique includes another: {target}'
    for circle in circles(edges):
        arrows = '; '.join(text for a in circle for b, text in edges[a].items() if b in circle)
        yield f'folders include each other in a circle: {", ".join(circle)} ({arrows})'


def check_dialect():
    for file in tracked(('.cl', '.clh')):
        code = re.sub(r'//.*', '', read(file))
        if re.search(r'\b__(global|kernel|local|constant)\b', code) and re.search(
                r'(?<!_)\b(global|kernel|local|constant)(?= |\*)', code):
            yield f'{file}: mixes __global and global'


def check_headers():
    files = set(tracked(('.h', '.cpp')))
    names = {os.path.basename(file) for file in files}
    for file in sorted(files):
        if not file.endswith('.cpp') or not file.startswith(('framework/', 'apps/lucarium/')) or '/templates/' in file:
            continue
        if file[:-4] + '.h' in files or file == 'apps/lucarium/start/start.cpp':  # main()
            continue
        head = re.match(r'(?://.*\n)*', read(file)).group(0).replace('\n// ', ' ')
        declared = re.search(r'Declared in ((?:[\w/]+\.h(?:, | and )?)+)', head)
        if not declared:
            yield f'{file}: has no header of its name; begin it with "// What it is. Declared in NAME.h."'
        for header in re.findall(r'[\w/]+\.h', declared.group(1)) if declared else ():
            if os.path.basename(header) not in names:
                yield f'{file}: names {header}, which does not exist'


def check_approx():
    for file in tracked(('.cpp', '.h')):
        if file.startswith('tests/') and 'doctest::Approx' in read(file):
            yield f'{file}: compares by doctest::Approx; take relative() or within() of tests/support/tolerance.h'


def check_links():
    folders = 'framework|kernels|techniques|tests|apps|tools|cmake|docs'
    path_rule = re.compile(rf'(?<![\w./$}}-])((?:{folders})/[\w./*-]+\.\w+)')
    # Neither targets of the build (techniques/all) nor names that a reader fills in (techniques/NAME); a source may be
    # named without its ending.
    folder_rule = re.compile(rf'(?<![\w./$}}<:-])((?:{folders})/(?!all\b|[A-Z])[\w/-]+)(?![\w.*/{{<$-])')
    for file in tracked(TEXTS):
        text = read(file)
        if file.endswith('.md'):
            for target in re.findall(r'\]\(([^)#\s]+)(?:#[^)]*)?\)', text):
                if '://' not in target and not os.path.exists(os.path.join(os.path.dirname(file), target)):
                    yield f'{file}: link to {target}, which does not exist'
        if file.startswith('tests/apps') or '/plugins/' in file:
            continue  # these write files of their own by such names
        for target in path_rule.findall(text):
            target = target.rstrip('.')
            found = os.path.exists(target) or ('*' in target and glob_exists(target))
            if not found and not any(os.path.exists(os.path.join(base, target)) for base in (
                    os.path.dirname(file), 'framework/lucarium', 'kernels/lucarium', 'docs')):
                yield f'{file}: names {target}, which does not exist'
        for target in folder_rule.findall(text):
            bases = ('.', os.path.dirname(file), 'framework/lucarium', 'kernels/lucarium', 'docs')
            found = [os.path.join(base, target.rstrip('/')) for base in bases]
            if not any(os.path.exists(path) or glob_exists(path + '.*') for path in found):
                yield f'{file}: names {target}, which does not exist'


def glob_exists(pattern):
    import glob
    return bool(glob.glob(pattern))


NUMBER = r'\d+(?:\.\d+)*'
CITATION = re.compile(r'(§+|\b(?:section|equation|figure|table|algorithm)s?(?=\s)|'
                      r'\b(?:sec|sect|eq|eqn|fig|tab|alg)s?\.)\s*'
                      rf'({NUMBER}(?:(?:,? and |,? to |, ){NUMBER})*)', re.I)
KINDS = {'§': 'section', 's': 'section', 'e': 'equation', 'f': 'figure', 't': 'table', 'a': 'algorithm'}
WORK = re.compile(r'\b([A-Z][\w\-]+)(?: et al\.| and [A-Z][\w\-]+|, [A-Z][^.;]{0,80}?)?,? \(?(?:19|20)\d\d\b')
# "folder/file.cl: one(), two()", beginning anywhere in a folder's path
PLACE = re.compile(r'([\w/]+\.(?:clh|cl|cpp|h)):\s+(\w+\(\)(?:,\s+\w+\(\))*)')


def comments(text):
    """(number of the first line, text) of blocks of comment lines, and of comments behind code."""
    block, first = [], 0
    for number, line in enumerate(text.split('\n') + [''], 1):
        whole = re.match(r'\s*///?<? ?(.*)', line)
        if whole:
            first = first or number
            block.append(whole.group(1))
            continue
        if block:
            yield first, '\n'.join(block)
            block, first = [], 0
        behind = re.search(r'//[/<]* ?(.*)', line)
        if behind:
            yield number, behind.group(1)


def paper_items(kind, numbers):
    for number in re.findall(NUMBER, numbers):
        yield f'{KINDS[kind[0].lower()]} {number}'


def check_places(file, first, text, sources):
    for match in PLACE.finditer(text):
        path, names = match.groups()
        found = [f for f in sources if f.endswith('/' + path)]
        near = [f for f in found if f.startswith('/'.join(file.split('/')[:2]) + '/')] or found
        if not near:
            yield f'{file}:{first}: names {path}, which does not exist'
        for name in re.findall(r'\w+', names) if near else ():
            if not any(re.search(rf'\b{name}\(', sources[f]) for f in near):
                yield f'{file}:{first}: {path} has no {name}()'


def check_table_rows(file):
    """clang-format may join the rows of a table of the paper; a joined row begins with a word of the one before."""
    for number, line in enumerate(read(file).splitlines(), 1):
        row = re.match(r'//   \S.*\S {3,}\S.*\.(cl|clh|cpp|h)\b', line)
        if row and not re.match(r'//   (section|equation|figure|table|algorithm) ', line):
            yield f'{file}:{number}: a row of the table of the paper begins with what is cited: a section, an equation'


def check_citations():
    papers = json.loads(read(CITATIONS))['papers']
    sources = {f: read(f) for f in tracked(SOURCES)}
    seen = [set() for _ in papers]
    for file, source in sources.items():
        own = next((p for p in papers if file.startswith(tuple(p['of']))), None)
        for first, text in comments(source):
            yield from check_places(file, first, text, sources)
            flat = text.replace('\n', ' ')
            works = [(m.start(), next((p for p in papers if m.group(1) in p['named']), None)) for m in
                     WORK.finditer(flat)]
            works += [(m.start(), own) for m in re.finditer(r'\b(?:the|its?) paper', flat) if own]
            for match in CITATION.finditer(flat):
                before = [w for w in sorted(works, key=lambda w: w[0]) if w[0] < match.start()]
                paper = before[-1][1] if before else own
                if not paper:
                    continue
                line = first + text.count('\n', 0, match.start())
                if file != paper['table'] and not match.group(1).isalpha():
                    yield f'{file}:{line}: {match.group(0)}: write section, equation or figure in full'
                if re.fullmatch(r'(section|equation|figure|table)s', match.group(1), re.I):
                    yield f'{file}:{line}: {match.group(0)}: write each in full, "equation 3, equation 4"'
                for item in paper_items(*match.groups()):
                    if item not in paper['items']:
                        yield f'{file}:{line}: {item} is not in {CITATIONS} for "{paper["paper"]}"'
                    elif file != paper['table']:
                        seen[papers.index(paper)].add(item)
    for paper, found in zip(papers, seen):
        yield from check_table_rows(paper['table'])
        for item in paper['cited']:
            if item not in found:
                yield f'{paper["table"]}: the code cites {item} nowhere else ({paper["items"][item]})'
    for file in tracked('.json'):
        own = next((p for p in papers if file.startswith(tuple(p['of']))), None)
        place = json.loads(read(file)).get('place') if own else None
        for match in CITATION.finditer(place or ''):
            for item in paper_items(*match.groups()):
                if item not in own['items']:
                    yield f'{file}: {item} is not in {CITATIONS} for "{own["paper"]}"'


def check_mutants():
    planted = set()
    for file in tracked(('.json',)):
        if not file.startswith('tests/mutation/'):
            continue
        area = json.loads(read(file))
        checks = {check['name'] for check in area['checks']}
        if not any(mutant.get('quick') for mutant in area['mutants']):
            yield f'{file}: none of its planted faults is tried in the quick set ("quick": true)'
        for mutant in area['mutants']:
            planted.add(mutant['file'])
            sources = [path for path in (f'{root}/{mutant["file"]}' for root in ROOTS) if os.path.exists(path)]
            found = sum(read(path).count(mutant['find']) for path in sources)
            if found != 1:
                yield f'{file}: "{mutant["name"]}" replaces text that {mutant["file"]} holds {found} times'
            if mutant['caught_by'] not in checks:
                yield f'{file}: "{mutant["name"]}" is caught by "{mutant["caught_by"]}", which is no check'
    exempt = json.loads(read(UNPLANTED))
    kernels = {file.split('/', 1)[1]: file for file in tracked(('.cl', '.clh')) if file.startswith(
        ('kernels/', 'framework/', 'techniques/'))}
    for name, file in sorted(kernels.items()):
        if name not in planted and name not in exempt:
            yield f'{file}: no planted fault of tests/mutation is in it'
    for name in exempt:
        if name not in kernels:
            yield f'{UNPLANTED}: there is no {name}'


RULES = {'format': check_format, 'width': check_width, 'folders': check_folders, 'options': check_options,
         'dialect': check_dialect, 'headers': check_headers, 'approx': check_approx, 'links': check_links,
         'pages': check_pages, 'citations': check_citations, 'mutants': check_mutants}


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] not in RULES:
        sys.exit(__doc__)
    os.chdir(sys.argv[2] if len(sys.argv) == 3 else os.path.join(os.path.dirname(__file__), '../..'))
    breaches = list(RULES[sys.argv[1]]())
    print('\n'.join(breaches))
    sys.exit(1 if breaches else 0)


if __name__ == '__main__':
    main()
