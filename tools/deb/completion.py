"""Man pages' texts and completion for bash and zsh, made of what a program says to --help."""

import re
import subprocess

OPTION = re.compile(r"^\s{2,}((?:-\w,\s*)?--[\w-]+)\b(.*)$")
COMMAND = re.compile(r"^  ([a-z][\w-]*) {2,}(\S.*)$")
BASH = """# Completion of {name} for bash, made of its --help.
_{function}() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} words="{top}"
{case}  if [[ $word == -* || {first} ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  fi
}}
complete -o default -F _{function} {name}
"""


class Program:
    """A program, and its commands, by what they say."""

    def __init__(self, path):
        self.path, self.name = path, path.name
        self.text = self.ask()
        after = self.text.split("Subcommands:")[1:]
        self.commands = dict(match.groups() for line in "".join(after).splitlines()
                             if (match := COMMAND.match(line)))
        self.texts = {command: self.ask(command) for command in self.commands}

    def ask(self, *words):
        done = subprocess.run([str(self.path), *words, "--help"], text=True, capture_output=True)
        text = done.stdout or done.stderr
        if not text.strip():
            raise SystemExit(f"deb: {self.path} says nothing to --help")
        return text

    def pages(self):
        """(words, one line about it, what it says) of each man page."""
        first = self.text.strip().splitlines()[0].removeprefix(f"{self.name}: ").rstrip(".")
        yield [self.name], first[:1].lower() + first[1:], self.usage(self.text)
        for command, about in self.commands.items():
            yield ([self.name, command], about[:1].lower() + about[1:],
                   self.usage(self.texts[command]))

    @staticmethod
    def usage(text):
        """What help2man takes for the synopsis: one line."""
        text = re.sub(r"(?m)^usage:", "Usage:", text)
        return re.sub(r"(?m)^(Usage: .*)\n +(?=\[)", r"\1 ", text)

    @staticmethod
    def options(text):
        """{"--option": (what it is for, whether a value follows)}"""
        found, last = {}, None
        for line in text.splitlines():
            match = OPTION.match(line)
            if match:
                last, rest = match[1].split(",")[-1].strip(), match[2]
                kind, *about = re.split(r"\s{2,}", rest, maxsplit=1)
                found.setdefault(last, (about[0].strip() if about else "", bool(kind)))
            elif last and line.startswith(" " * 20) and not found[last][0]:
                found[last] = (line.strip(), found[last][1])
        for name in re.findall(r"\[(--[\w-]+)", text):
            found.setdefault(name, ("", True))
        return found

    def bash(self):
        top = " ".join([*self.commands, *self.options(self.text)])
        case, first = "", "COMP_CWORD -eq 0"
        if self.commands:
            rows = "".join(f'    {command}) words="{" ".join(self.options(text))}" ;;\n'
                           for command, text in self.texts.items())
            case = f"  ((COMP_CWORD > 1)) && case ${{COMP_WORDS[1]}} in\n{rows}  esac\n"
            first = "COMP_CWORD -eq 1"
        return BASH.format(name=self.name, function=self.name.replace("-", "_"), top=top, case=case,
                           first=first)

    @staticmethod
    def zsh_words(text):
        def quoted(about):
            return re.sub(r"(['\[\]:\\])", lambda m: "'\\''" if m[1] == "'" else "\\" + m[1], about)

        return "".join(f" \\\n      '*{name}[{quoted(about)}]{':value:_files' if value else ''}'"
                       for name, (about, value) in Program.options(text).items())

    def zsh(self):
        function = self.name.replace("-", "_")
        head = f"#compdef {self.name}\n# Made of its --help.\n_{function}() {{\n"
        if not self.commands:
            words = self.zsh_words(self.text)
            return head + f"  _arguments{words} \\\n      '*:file:_files'\n}}\n_{function} \"$@\"\n"
        listed = "".join(f"    '{command}:{about}'\n" for command, about in
                         ((c, a.replace("'", "").replace(":", ",")) for c, a in
                          self.commands.items()))
        cases = "".join(f"    {command}) _arguments{self.zsh_words(text)} \\\n"
                        f"      '*:file:_files' ;;\n" for command, text in self.texts.items())
        return (head + f"  local -a commands=(\n{listed}  )\n"
                f"  if ((CURRENT == 2)); then _describe command commands; return; fi\n"
                f"  local command=$words[2]\n  shift words; ((CURRENT--))\n"
                f"  case $command in\n{cases}  esac\n}}\n_{function} \"$@\"\n")
