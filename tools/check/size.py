"""A function fits a screen (70 lines, brace to brace with its head), a line 100 columns."""
import re

LINES_MAX = 70
COLUMNS_MAX = 100
# Markdown tables and data may be wide; a program may not.
WIDTH_OF = (".h", ".cc", ".py", ".sh", "Makefile")
LONG_WORD = re.compile(r"^\S*\s*(//|#|\*)?\s*\S*://\S+$")  # an address cannot be broken

BLANKED = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(?P<tag>\w*)\(.*?\)(?P=tag)"|"(?:\\.|[^"\\\n])*"'
    r"|(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'", re.S)
# What stands before the brace of a function body: `)` and what may follow a parameter list.
BODY = re.compile(
    r"\)\s*(const|noexcept|override|final|mutable|&|&&|->\s*[\w:<>,\s*&]+|\s)*$|\btry\s*$")
CONTROL = re.compile(r"\b(if|for|while|switch|catch)\b[^;{}]*$", re.S)


def blank(text):
    """Comments and literals become spaces; lines stay where they are."""
    return BLANKED.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), text)


def statement_start(text, brace):
    """Where the declaration that ends in this brace begins: after the last ; { } or # line."""
    start = max(text.rfind(c, 0, brace) for c in ";{}") + 1
    while text[start:brace].lstrip().startswith("#"):
        start = text.index("\n", start + text[start:].index("#")) + 1
    return start + len(text[start:brace]) - len(text[start:brace].lstrip())


def is_function(head):
    """A constructor's initializers hide its `)`: `A::A(int x) : x_(x) {` or `: x_{x} {`."""
    if CONTROL.search(head) or "=" in head.split("(")[0]:
        return False
    return bool(BODY.search(head)) and "(" in head


def functions(source):
    """(first line, last line) of every outermost function body."""
    text = blank(source)
    depth, function_depth, first = 0, None, 0
    for match in re.finditer(r"[{}]", text):
        if match[0] == "{":
            if function_depth is None:
                start = statement_start(text, match.start())
                if is_function(text[start:match.start()]):
                    function_depth, first = depth, text.count("\n", 0, start) + 1
            depth += 1
        else:
            depth -= 1
            if function_depth is not None and depth == function_depth:
                yield first, text.count("\n", 0, match.start()) + 1
                function_depth = None


def check(tree, options):
    del options
    findings = []
    for path, text in tree.items():
        if path.endswith(WIDTH_OF):
            for number, line in enumerate(text.splitlines(), 1):
                if len(line) > COLUMNS_MAX and not LONG_WORD.match(line):
                    findings.append(f"{path}:{number}: {len(line)} columns, at most {COLUMNS_MAX}")
        if path.endswith((".h", ".cc")):
            for first, last in functions(text):
                lines = last - first + 1
                if lines > LINES_MAX:
                    findings.append(f"{path}:{first}: {lines} lines, at most {LINES_MAX}")
    return findings


def self_test(options):
    body = "  x();\n" * 69
    heads = ["void f() {\n", "A::A(int x) : x_(x) {\n", "int A::f(int a,\n  int b) const {\n",
             "TEST(a, b) {\n", "template <class T>\nauto f(T x) -> int {\n",
             "namespace n {\nstruct A {\n  void f() {\n", "// it's {\nvoid f() {\n"]
    bad = [head + body + "}" + "}" * (head.count("{") - 1) + "\n" for head in heads]
    bad += ["int a;  // " + "x" * 100 + "\n"]
    good = ["void f() {\n" + "  x();\n" * 68 + "}\n", "namespace n {\n" + "int x;\n" * 99 + "}\n",
            "constexpr int k[] = {\n" + "  1,\n" * 99 + "};\n",
            "struct A {\n" + "  int f() { return '{'; }\n" * 99 + "};\n"]
    blind = [text[:60] for text in bad if not check({"a.cc": text}, options)]
    return blind + [f"that this is fine: {t[:40]}" for t in good if check({"a.cc": t}, options)]
