#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The commands that README, pages and --help show: page_commands.py PROGRAM SOURCE. Every command and option exists;
what stands alone on a line of a code block is also run, in a folder of its own per page, at a size and budget that take
a second. Prints one line per command: "ok …", "skipped …" with the reason, or "FAILED …"."""
import json
import os
import pathlib
import re
import shlex
import struct
import subprocess
import sys
import tempfile

# Smaller settings, added where the command takes them; the last of several wins.
SMALL = {
    'render': ['--size', '16x12', '--iterations', '1', '--overwrite'],
    'compare': ['--size', '16x12', '--iterations', '1', '--reference-spp', '32', '--seeds', '1', '--overwrite'],
    'reference': ['--size', '16x12', '--spp', '2', '--overwrite'],
    'scene': ['--texture-size', '64'],
}
DROPPED = {'render': ('--time', '--wall-time', '--spp', '--frames', '--fps'),
           'compare': ('--time', '--spp', '--relmse'), 'reference': ('--relmse', '--spp')}

# Of techniques that prepare a scene first: what keeps that short, for `render` with this technique alone.
COARSE = {'bundle_exchange': ['texels=1024', 'access_rays=128'],
          'virtual_light_field': ['texels=1024', 'dir_n=2', 'cells=16'],
          'voxel_abuffer': ['abuffer_size=128']}

OPTION = re.compile(r'(?<=\s)(--[a-z][a-z0-9-]*|-[a-zA-Z](?=\s|$))')
assert OPTION.findall('lucarium scene a.glb --atlas-texcoord1 -q --size=8x8 -V') == [
    '--atlas-texcoord1', '-q', '--size', '-V']

NOT_RUN = (
    (r'--executor', 'needs Slurm; compare/execute/slurm_test plays it'),
    (r'[|>]', "a shell's work; cli/completion_* and cli/manual/manual_test do it"),
    (r'…|\[-|\bNAME\b|\bDIR\b|SCENE', 'shows a form'),
    (r'my_technique|occlusion|instant_radiosity|new-technique', 'the sdk tests run it with a plug-in that they build'),
    (r'--watch|ref\.exr', 'waits, or needs what another page makes'),
    (r'^lucarium reproduce (?!--list)', 'cli/commands/reproduce_test runs experiments'),
    (r'^lucarium view', 'serves until it is interrupted; cli/view/view_test does it'),
    (r'^lucarium check', 'cli/commands/check_test runs checks'),
    (r'micro_rendering|fox\.glb', 'its points take seconds; cli/commands/render_test renders with it'),
)


def commands(page):
    """(command, stands in a code block) of a page, continued lines joined, comments and prompts left out."""
    lines, code, i = page.read_text(encoding='utf8').split('\n'), False, 0
    while i < len(lines):
        line = lines[i]
        if line.lstrip().startswith('```'):
            code = not code
        text = line.strip().removeprefix('$ ')
        if (code or line.startswith('    ')) and re.match(r'([A-Z_]+=\S+ )*lucarium ', text):
            while text.endswith('\\'):
                i += 1
                text = text[:-1] + lines[i].strip()
            yield re.sub(r'^([A-Z_]+=\S+ )*', '', re.sub(r'\s+#.*', '', text)), True
        else:
            for text in re.findall(r'`(lucarium [a-z][^`]*)`', line):
                yield text, False
        i += 1


class Tester:
    def __init__(self, program, source):
        self.program, self.source, self.helps, self.names, self.failed = program, source, {}, {}, False

    def call(self, words, folder=None):
        return subprocess.run([self.program, *words], cwd=folder, capture_output=True, text=True, timeout=1500,
                              stdin=subprocess.DEVNULL)

    def say(self, verdict, what, why=''):
        self.failed |= verdict == 'FAILED'
        print(f'{verdict:8}{what}{": " + why if why else ""}', flush=True)

    def help_of(self, command):
        if command not in self.helps:
            answer = self.call([command, '--help'])
            self.helps[command] = answer.stdout if answer.returncode == 0 else None
        return self.helps[command]

    def names_of(self, command):
        """All names of the command's options; --help shows one of each."""
        if command not in self.names:
            declared = json.loads(self.call(['commands', '--json']).stdout)['commands']
            options = next((each['options'] for each in declared if each['name'] == command), [])
            self.names[command] = {name for option in options for name in option['names']}
        return self.names[command]

    def exists(self, line):
        """Commands of the line and their options are there; the complaint otherwise."""
        parts = [re.sub(r'^\s*(do\s+)?', '', part) for part in re.split(r'&&|;', line)]
        return next((each for each in map(self.part_exists, parts) if each), '')

    def part_exists(self, text):
        command = text.split()[1] if text.startswith('lucarium ') else ''
        if not re.fullmatch(r'[a-z-]+', command) or command.startswith('-'):
            return ''
        help_text = self.help_of(command)
        if help_text is None:
            return f'there is no command {command}'
        for option in OPTION.findall(text):
            shown = re.search(rf'(^|[\s,]){re.escape(option)}([\s,=\[]|$)', help_text, re.M)
            if not shown and option not in self.names_of(command):
                return f'{command} has no option {option}'
        return ''

    def reduced(self, text):
        words = shlex.split(text)[1:]
        command, rest, kept = words[0], words[1:], []
        while rest:
            word = rest.pop(0)
            if word in DROPPED.get(command, ()):
                rest.pop(0)
            else:
                kept.append(word)
        if '--comparison' in kept:
            return [command, *kept, *([] if '--dry-run' in kept else ['--overwrite'])]  # the file says the rest
        small = list(SMALL.get(command, []))
        for technique, values in COARSE.items():
            if command == 'render' and re.search(rf'(-t|--technique)[ =]{technique}', text):
                small = [word for value in values for word in ('-p', value)] + small
        if command == 'render' and not {'-o', '--output', '--save-state'} & set(kept):
            small = small[:-1]  # nothing to replace
        return [command, *kept, *(small[:-1] if '--extend' in kept else small)]

    def stock(self, folder, texts):
        """The files that the pages speak of; of `texts` alone what takes long."""
        for name in 'FILE.gltf', 'FILE.glb', 'scene.glb', 'hall.glb':
            glb = folder / 'box.glb'
            if not glb.exists():
                self.call(['scene', 'builtin:cornell', '--export', str(glb)], folder)
            (folder / name).write_bytes(glb.read_bytes())
        for name in 'box.glb', 'box.glb.lucarium.json':
            (folder / name).unlink(missing_ok=True)
        for name in 'sky.hdr', 'venice.hdr':
            pixels = bytes((128, 128, 128, 129)) * 8
            (folder / name).write_bytes(b'#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n' + pixels)
        for name in 'a.exr', 'b.exr', 'test.exr':
            self.call(['render', 'builtin:cornell', *SMALL['render'], '-o', name], folder)
        (folder / 'study.json').write_text(
            '{"schema": "lucarium-comparison-1", "scenes": ["builtin:cornell"], "techniques": ["path_tracing"],'
            ' "budgets": [{"iterations": 1}], "size": [16, 12], "reference": {"samples": 32}}')
        (folder / 'walk.json').write_text(
            '{"keys": [{"seconds": 0, "eye": [0, 1, 3], "target": [0, 1, 0]},'
            ' {"seconds": 2, "eye": [0.5, 1, 3], "target": [0, 1, 0]}]}')
        if any('lucarium state' in text for text in texts):
            self.call(['render', 'builtin:cornell', '-t', 'bundle_exchange:texels=1024,directions=8', '--size', '16x12',
                       '--save-state', 'cornell.state'], folder)

    def run_all(self, name, texts):
        with tempfile.TemporaryDirectory() as work:
            folder, stocked, texts = pathlib.Path(work), False, list(texts)
            for text, block in dict.fromkeys(texts):
                what = f'{name}: {text}'
                problem = self.exists(text)
                reason = next((why for rule, why in NOT_RUN if re.search(rule, text)), '' if block else 'in a sentence')
                if problem:
                    self.say('FAILED', what, problem)
                elif reason:
                    self.say('skipped', what, f'{reason}; its options exist')
                else:
                    if not stocked:
                        self.stock(folder, [words for words, _ in texts])
                        stocked = True
                    answer = self.call(self.reduced(text), folder)
                    # Status 1: a limit is exceeded. The test's images are noisy, so --max-relmse may say so.
                    failed = answer.returncode not in ((0, 1) if '--max-relmse' in text else (0,))
                    self.say('FAILED' if failed else 'ok', what, answer.stderr.strip()[-300:] if failed else '')


def main():
    program, source = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    tester = Tester(program, source)
    os.environ.setdefault('LC_ALL', 'C.UTF-8')
    pages = [source / 'README.md', *sorted((source / 'docs').rglob('*.md')), *sorted((source / 'apps').rglob('*.md'))]
    for page in pages:
        tester.run_all(page.relative_to(source), commands(page))
    top = tester.call(['--help']).stdout
    examples = []
    for command in re.findall(r'^  ([a-z-]+)  ', top, re.M):
        help_text = tester.help_of(command)
        if help_text is None:
            tester.say('FAILED', f'lucarium {command} --help')
            continue
        shown = re.search(r'^Examples\n((?:  .*\n)*)', help_text, re.M)
        own = re.findall(r'^  (.*\blucarium .*)', shown[1] if shown else '', re.M)
        if len(own) != 2 or not (source / re.search(r'^More: (.*)', help_text, re.M)[1]).exists():
            tester.say('FAILED', f'lucarium {command} --help', 'it needs two examples and a page')
        examples += [(text, text.startswith('lucarium')) for text in own]
    tester.run_all('--help', examples)
    sys.exit(1 if tester.failed else 0)


main()
