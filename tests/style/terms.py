#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The words of the sources: terms.py [ROOT]. Rules in terms.json:
  phrases     expressions that a reader stumbles over, in comments, texts, pages and experiments
  terms       words that were replaced by the field's own, in the same places; docs/notation.md explains those
  names       identifiers that were replaced likewise, in code; "in": only below these paths, as for the others
  exceptions  what of these a path may use, with the reason; one that is used nowhere is a breach
and one for the texts of parameters, which are help, JSON and docs/techniques.md at once: one clause that begins in
lower case, without a full stop, of at most WORDS words and JOINTS semicolons.
Prints one line per breach and exits with 1 if there is one."""
import json
import os
import re
import sys

import check

WORDS = 30
JOINTS = 2
RULES = 'tests/style/terms.json'
OWN = ('tests/style/terms.json', 'tests/style/terms.py')  # which hold the words that they forbid
CODE = ('.cpp', '.h', '.cl', '.clh')
PROSE = ('.md', '.py', '.cmake', '.txt', '.js', '.html')

# A comment, a text with its parts on several lines, or a character of code. Preprocessor lines are code.
TOKEN = re.compile(r'(?P<comment>//[^\n]*|/\*.*?\*/)'
                   r'|(?P<include>#\s*include[^\n]*)'
                   r'|(?P<raw>R"(?P<mark>\w*)\(.*?\)(?P=mark)")'
                   r'|(?P<text>"(?:[^"\\\n]|\\.)*"(?:\s*"(?:[^"\\\n]|\\.)*")*)'
                   r"|(?P<char>'(?:[^'\\\n]|\\.)+')", re.S)
PARAMETER = re.compile(r'\bv\.(?:number|flag|choice|presets)\(\s*(?:"(?P<name>\w+)"|\{).*?'
                       r'(?P<text>"(?:[^"\\\n]|\\.)*"(?:\s*"(?:[^"\\\n]|\\.)*")*)\);$', re.S | re.M)


def joined(text):
    """The value of a text of several parts, escapes left as they are."""
    return ''.join(re.findall(r'"((?:[^"\\\n]|\\.)*)"', text))


def words_and_names(source):
    """Comments and texts, and the code without them: two texts with the lines of the source."""
    prose, code, end = [], [], 0

    def blank(part):
        return re.sub(r'[^\n]', ' ', part)

    for match in TOKEN.finditer(source):
        between, token = source[end:match.start()], match.group(0)
        end = match.end()
        spoken = match.lastgroup in ('comment', 'text') or match.group('raw')
        code += [between, blank(token)]
        prose += [blank(between), token if spoken else blank(token)]
    code.append(source[end:])
    prose.append(blank(source[end:]))
    return ''.join(prose), ''.join(code)


def page(text):
    """A page without code blocks, code, and addresses of links, line by line."""
    lines, fenced = [], False
    for line in text.split('\n'):
        fence = line.lstrip().startswith('```')
        fenced ^= fence
        quoted = fenced or fence or line.startswith('    ')
        lines.append('' if quoted else re.sub(r'`[^`]*`|\]\([^)]*\)', '', line))
    return '\n'.join(lines)


def flat(prose):
    """Lines of a comment or text joined, since phrases go over the end of a line; as long as before."""
    return re.sub(r'"\s*"|\n\s*(?:///?<?|#)?', lambda match: ' ' * len(match.group(0)), prose)


class Rules:
    def __init__(self):
        rules = json.loads(check.read(RULES))
        self.prose = [self.compiled(rule, re.I) for rule in rules['phrases'] + rules['terms']]
        self.names = [self.compiled(rule) for rule in rules['names']]
        self.exceptions = rules['exceptions']
        self.used = set()

    @staticmethod
    def compiled(rule, flags=0):
        pattern = re.compile(rf'(?<![\w-])(?:{rule["find"]})(?![\w-])'.replace(' ', r'\s+'), flags)
        return pattern, rule['use'], tuple(rule.get('in', ['']))

    def allowed(self, path, word):
        for index, exception in enumerate(self.exceptions):
            if path.startswith(exception['path']) and re.fullmatch(exception['find'], word):
                self.used.add(index)
                return True
        return False

    def breaches(self, path, text, source, rules):
        """(line of `source`, word, what to write) of what `rules` find in `text`, which is as long."""
        for pattern, use, folders in rules:
            for match in pattern.finditer(text) if path.startswith(folders) else ():
                word = re.sub(r'\s+', ' ', match.group(0))
                if not self.allowed(path, word):
                    yield source.count('\n', 0, match.start()) + 1, word, use

    def unused(self):
        for index, exception in enumerate(self.exceptions):
            if index not in self.used:
                yield f'{RULES}: the exception of {exception["path"]} for "{exception["find"]}" is not used'


def parameter_breaches(path, source):
    for match in PARAMETER.finditer(source):
        text = joined(match.group('text'))
        faults = []
        if len(text.split()) > WORDS:
            faults.append(f'{len(text.split())} words, more than {WORDS}')
        if text.count(';') > JOINTS:
            faults.append(f'{text.count(";")} semicolons, more than {JOINTS}')
        if text.endswith('.'):
            faults.append('it ends with a full stop')
        if re.match(r'[A-Z][a-z]+ ', text) and not text.startswith(('Owen', 'Russian')):
            faults.append('it begins with a capital letter')
        line = source.count('\n', 0, match.start()) + 1
        for fault in faults:
            yield f'{path}:{line}: text of the parameter {match.group("name") or "preset"}: {fault}'


def breaches():
    rules = Rules()
    for path in check.tracked(CODE + PROSE + ('.json',)):
        if path in OWN or path in check.GENERATED or path.endswith('.json') and '/experiments/' not in path:
            continue
        source = check.read(path)
        names = ''
        if path.endswith(CODE):
            prose, names = words_and_names(source)
            yield from parameter_breaches(path, source)
        else:
            prose = page(source) if path.endswith('.md') else source
        found = [*rules.breaches(path, flat(prose), prose, rules.prose),
                 *rules.breaches(path, names, names, rules.names)]
        for line, word, use in sorted(found):
            yield f'{path}:{line}: "{word}": write {use}'
    yield from rules.unused()


def main():
    os.chdir(sys.argv[1] if len(sys.argv) == 2 else os.path.join(os.path.dirname(__file__), '../..'))
    lines = list(breaches())
    print('\n'.join(lines))
    sys.exit(1 if lines else 0)


if __name__ == '__main__':
    main()
