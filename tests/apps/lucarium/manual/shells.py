#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Completion in a real shell: shells.py PROGRAM bash|zsh|fish. The script that `lucarium completion` writes is read by
the shell, and the shell is asked what it offers and what a Tab key makes of a line. One line per check: "ok …" or
"FAILED …". Exit code 77 when the shell is absent."""
import json
import os
import pathlib
import pty
import re
import select
import shutil
import subprocess
import sys
import tempfile

PATIENCE = 300  # seconds; a busy machine is slow, not wrong
DUMP = '\x18\x04'  # the keys that write the line: Ctrl-X Ctrl-D


class Terminal:
    """A shell with a terminal of its own."""

    def __init__(self, words, folder, environment):
        self.process, self.descriptor = pty.fork()
        if self.process == 0:
            os.chdir(folder)
            os.execvpe(words[0], words, environment)
        self.seen = ''

    def send(self, text):
        os.write(self.descriptor, text.encode())

    def wait_for(self, pattern):
        """The text that matched; what came before it is dropped."""
        while not (match := re.search(pattern, self.seen, re.S)):
            if not select.select([self.descriptor], [], [], PATIENCE)[0]:
                raise TimeoutError(f'{pattern} never came: {self.seen[-500:]!r}')
            self.seen += os.read(self.descriptor, 65536).decode(errors='replace')
        self.seen = self.seen[match.end():]
        return match.group(1)

    def line_after(self, keys):
        """The line once the keys have been pressed, and empty again."""
        self.send(keys + DUMP)
        line = self.wait_for(r'LINE<(.*?)>END')
        self.send('\x15')  # Ctrl-U
        return line

    def close(self):
        os.close(self.descriptor)  # which hangs up
        os.waitpid(self.process, 0)


class Bash:
    SYNTAX = ['bash', '-n']

    def __init__(self, script, folder, environment):
        self.script, self.folder, self.environment = script, folder, environment
        self.terminal = Terminal(['bash', '--norc', '--noprofile', '-i'], folder, environment)
        self.terminal.send(f'bind \'set enable-bracketed-paste off\'; source {script}; bind -x \'"\\C-x\\C-d": printf '
                           '"LINE<%s>END" "$READLINE_LINE"\'; PS1="READY""NOW"\n')
        self.terminal.wait_for('(READYNOW)')  # the prompt, which is there once the shell reads keys

    def candidates(self, line):
        """As readline calls the function, without the breaks at : and = that would cut the answers."""
        test = f'''source {self.script}; COMP_WORDBREAKS=$' \\t\\n'
            COMP_LINE={json.dumps(line)}; COMP_POINT=${{#COMP_LINE}}
            read -ra COMP_WORDS <<<"$COMP_LINE"; [[ $COMP_LINE == *' ' ]] && COMP_WORDS+=('')
            COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _lucarium lucarium "${{COMP_WORDS[-1]}}"
            ((${{#COMPREPLY[@]}})) && printf '%s\\n' "${{COMPREPLY[@]}}"'''
        run = subprocess.run(['bash', '--norc', '-c', test], cwd=self.folder, env=self.environment, capture_output=True,
                             text=True, timeout=PATIENCE)
        assert not run.stderr, run.stderr
        return run.stdout.split('\n')[:-1]

    def line_after_tab(self, line):
        return self.terminal.line_after(line + '\t')


class Zsh:
    SYNTAX = ['zsh', '-n']
    # What compadd is given is what is offered; -O, -A and -D ask of it only.
    SETUP = r'''PS1=; unsetopt zle_bracketed_paste; fpath=({folder} $fpath); autoload -U compinit; compinit -u -D
compadd() {{
  if [[ ${{@[1,(i)(-|--)]}} == *-(O|A|D)\ * ]]; then builtin compadd "$@"; return; fi
  local -a hits; builtin compadd -A hits "$@"; (( $#hits )) && print -rl -- $hits >> {folder}/offered
  builtin compadd "$@"
}}
dump() {{ print -rn -- "LINE<$BUFFER>END"; }}; zle -N dump; bindkey '^X^D' dump; bindkey '^U' kill-whole-line
setopt no_list_beep no_auto_list no_auto_menu; zstyle ':completion:*' menu no
zle-line-init() {{ print -rn READYNOW; }}; zle -N zle-line-init  # the shell reads keys
'''

    def __init__(self, script, folder, environment):
        self.offered = folder / 'offered'
        shutil.copy(script, folder / '_lucarium')
        (folder / 'setup.zsh').write_text(self.SETUP.format(folder=folder))
        self.terminal = Terminal(['zsh', '-f', '-i'], folder, environment)
        self.terminal.send(f'source {folder}/setup.zsh\n')
        self.terminal.wait_for('(READYNOW)')

    def candidates(self, line):
        self.offered.unlink(missing_ok=True)
        self.line_after_tab(line)
        return self.offered.read_text().split('\n')[:-1] if self.offered.exists() else []

    def line_after_tab(self, line):
        return self.terminal.line_after(line + '\t')


class Fish:
    SYNTAX = ['fish', '--no-execute']

    def __init__(self, script, folder, environment):
        self.script, self.folder, self.environment = script, folder, environment

    def candidates(self, line):
        run = subprocess.run(['fish', '--no-config', '-c', f'source {self.script}; complete -C {json.dumps(line)}'],
                             cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=PATIENCE)
        assert not run.stderr, run.stderr
        return [answer.split('\t')[0] for answer in run.stdout.split('\n')[:-1]]

    def line_after_tab(self, line):
        """The only one that there is takes the place of the last word."""
        (found,) = self.candidates(line)
        return line[:line.rfind(' ') + 1] + found


def check(name, passed, detail=''):
    print('ok' if passed else 'FAILED', name, '' if passed else detail, flush=True)
    check.failed |= not passed


check.failed = False


def offers(shell, line, *wanted, only=False):
    found = shell.candidates(line)
    passed = set(wanted) == set(found) if only else set(wanted) <= set(found)
    check(f'{line!r}', passed and len(found) == len(set(found)), f'offers {found}, not {wanted}')


def options(command, short):
    return [name for option in command['options'] for name in option['names'] if short or name.startswith('--')]


def check_shell(shell, declared):
    commands = [command['name'] for command in declared['commands']]
    offers(shell, 'lucarium ', *commands, only=True)
    offers(shell, 'lucarium --quiet repo', 'report', only=True)
    offers(shell, 'lucarium --', *options(declared['program'], False), only=True)
    for command in declared['commands']:
        offers(shell, f'lucarium {command["name"]} --', *options(command, False), only=True)
    short = options(next(c for c in declared['commands'] if c['name'] == 'render'), True)
    found = set(shell.candidates('lucarium render -')) | set(shell.candidates('lucarium render --'))
    check('short options', found == set(short), f'{found ^ set(short)}')
    # Values to choose from, after a space and after =.
    offers(shell, 'lucarium diff a.exr b.exr --map-of ', 'signed', 'ldr_flip', 'hdr_flip', only=True)
    offers(shell, 'lucarium completion ', 'bash', 'zsh', 'fish', only=True)
    offers(shell, 'lucarium help repr', 'reproduce', only=True)
    offers(shell, 'lucarium render --size ', only=True)
    # Names that the program knows, a plug-in's as well.
    offers(shell, 'lucarium render -t ', 'path_tracing', 'constant')
    offers(shell, 'lucarium render --technique ', 'path_tracing', 'constant')
    offers(shell, 'lucarium check pa', 'path_tracing', only=True)
    offers(shell, 'lucarium render -t path_tracing:esti', 'path_tracing:estimator=', only=True)
    offers(shell, 'lucarium render builtin:cornell -t constant -p re', 'red=', only=True)
    offers(shell, 'lucarium render builtin:cornell -p estimator=m', 'estimator=mis', only=True)
    offers(shell, 'lucarium check path_tracing -p estimator=m', 'estimator=mis', only=True)
    offers(shell, 'lucarium scene builtin:at', 'builtin:atrium', only=True)
    offers(shell, 'lucarium scene builtin:debris:', 'builtin:debris:pieces=')
    # Words by their place, and no more than there are.
    for line in ('lucarium completion bash ', 'lucarium diff -o map.png a.exr b.exr ',
                 'lucarium scene builtin:atrium bui'):
        words = [word for word in shell.candidates(line) if not word.startswith('-')]  # zsh goes on with options
        check(f'no word behind {line!r}', not words, f'offers {words}')
    offers(shell, 'lucarium render "builtin:at', 'builtin:atrium', only=True)
    offers(shell, "lucarium render -t 'path_tracing:esti", 'path_tracing:estimator=', only=True)
    offers(shell, 'lucarium --quiet compare builtin:cornell builtin:at', 'builtin:atrium', only=True)
    # What a Tab makes of the line: the rest of the word, and a space where nothing can follow it.
    for line, wanted in (('lucarium rend', 'lucarium render'),
                         ('lucarium render --iter', 'lucarium render --iterations'),
                         ('lucarium render builtin:at', 'lucarium render builtin:atrium'),
                         ('lucarium render -t path_tracing:esti', 'lucarium render -t path_tracing:estimator='),
                         ('lucarium render -t path_tracing -p estimator=m',
                          'lucarium render -t path_tracing -p estimator=mis'),
                         ('lucarium render -tpath_trac', 'lucarium render -tpath_tracing'),
                         ('lucarium render -tpath_tracing:esti', 'lucarium render -tpath_tracing:estimator='),
                         ('lucarium check path_tracing -pestimator=m',
                          'lucarium check path_tracing -pestimator=mis'),
                         ('lucarium render "a b.glb" -t path_trac', 'lucarium render "a b.glb" -t path_tracing'),
                         ('lucarium render hal', 'lucarium render hall.glb'),
                         ('lucarium render hall.glb -o box', 'lucarium render hall.glb -o box.exr'),
                         ('lucarium render hall.glb --output box', 'lucarium render hall.glb --output box.exr'),
                         ('lucarium diff box.exr sec', 'lucarium diff box.exr second.exr'),
                         ('lucarium report re', 'lucarium report results/')):
        line_then = shell.line_after_tab(line)
        # zsh puts = behind an option, which a space takes away again.
        check(f'Tab behind {line!r}', line_then.rstrip(' ') in (wanted, wanted + '='), f'gives {line_then!r}')
        check('and no space within a word', not line_then.endswith(('= ', ': ')), f'gives {line_then!r}')


def check_quotes(shell):
    """A Tab within open quotes; bash and zsh close them behind a word that is whole."""
    for line, wanted in (('lucarium render "builtin:at', 'lucarium render "builtin:atrium'),
                         ("lucarium render -t 'path_tracing:esti", "lucarium render -t 'path_tracing:estimator=")):
        line_then = shell.line_after_tab(line)
        check(f'Tab behind {line!r}', line_then.rstrip(' "\'') == wanted, f'gives {line_then!r}')


def main():
    program, name = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
    if not shutil.which(name):
        print(f'skipped: {name} is not installed')
        sys.exit(77)
    with tempfile.TemporaryDirectory() as work:
        folder = pathlib.Path(work).resolve()
        (folder / 'results').mkdir()
        for file in 'hall.glb', 'box.exr', 'second.exr', 'restless.txt':
            (folder / file).touch()
        environment = {**os.environ, 'PATH': f'{program.parent}:{os.environ["PATH"]}', 'HOME': work, 'TERM': 'dumb',
                       'LC_ALL': 'C.UTF-8', 'XDG_CONFIG_HOME': work, 'XDG_DATA_HOME': work}
        script = folder / f'completion.{name}'
        script.write_text(subprocess.run([program, 'completion', name], capture_output=True, text=True,
                                         check=True).stdout)
        shell_class = {'bash': Bash, 'zsh': Zsh, 'fish': Fish}[name]
        syntax = subprocess.run([*shell_class.SYNTAX, script], capture_output=True, text=True)
        check('syntax', syntax.returncode == 0 and not syntax.stderr, syntax.stderr)
        declared = json.loads(subprocess.run([program, 'commands', '--json'], capture_output=True, text=True,
                                             check=True).stdout)
        shell = shell_class(script, folder, environment)
        check_shell(shell, declared)
        if shell_class is not Fish:  # which is asked for words, not for lines
            check_quotes(shell)
    sys.exit(1 if check.failed else 0)


main()
