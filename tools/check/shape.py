"""Below tools a file has 500 lines at most and a class 25 methods, private ones too, but for a
reason written beside it: `// Long file: why` anywhere in the file, `// Many methods: why` in the
three lines above the class."""
import re

from size import blank

LINES_MAX = 500
METHODS_MAX = 25
BELOW_TOOLS = ("board/", "bsp/", "core/", "modules/")
CLASS = re.compile(r"^[ \t]*(?:template\s*<[^{};]*>\s*)?(?:class|struct)\s+(\w+)[^;{}()]*\{", re.M)
# A name, its parameters, and what may follow them up to the end of a declaration.
METHOD = re.compile(r"(?:[~\w]+|operator\s*\S+)\s*\([^;{}]*$", re.S)
NOT_METHOD = re.compile(r"^\s*(?:using|typedef|friend|static_assert|return|enum)\b|=[^=]*\(", re.S)
POINTER = re.compile(r"\(\s*\*")  # to a function: data


def body_of(text, begin):
    """The text between a class's braces without what stands in braces within it."""
    depth, out = 1, []
    for at in range(begin, len(text)):
        depth += (text[at] == "{") - (text[at] == "}")
        if depth == 0:
            break
        if depth == 1:
            out.append(";" if text[at] == "}" else text[at])
    return "".join(out)


def methods(body):
    """Declarations and definitions of functions at the top of a class body."""
    body = re.sub(r"\b(?:public|private|protected)\s*:", ";", body)
    count = 0
    for statement in body.split(";"):
        head = re.sub(r"(?m)^\s*(#|template\s*<).*$", "", statement).strip()
        name = head.split("(")[0] + "("
        count += bool(METHOD.search(head) and not NOT_METHOD.search(name)
                      and not POINTER.match(head[len(name) - 1:]))
    return count


def check(tree, options):
    del options
    findings = []
    for path, text in tree.items():
        if not path.endswith((".h", ".cc")) or not path.startswith(BELOW_TOOLS):
            continue
        lines = text.count("\n")
        if lines > LINES_MAX and "// Long file: " not in text:
            findings.append(f"{path}:1: {lines} lines, at most {LINES_MAX}")
        plain = blank(text)
        for match in CLASS.finditer(plain):
            count = methods(body_of(plain, match.end()))
            first = plain.count("\n", 0, match.start()) + 1
            above = "\n".join(text.splitlines()[max(0, first - 4):first])
            if count > METHODS_MAX and "// Many methods: " not in above:
                findings.append(f"{path}:{first}: {match[1]} has {count} methods, "
                                f"at most {METHODS_MAX}")
    return findings


def self_test(options):
    many = "".join(f"  int f{i}(int a, int b = g(1)) const;\n" for i in range(26))
    inline = "".join(f"  int f{i}() {{ if (a) b(); return 1; }}\n" for i in range(26))
    few = "".join(f"  int f{i}();\n  int m{i}_ = g({i});\n  void (*p{i})(int) = nullptr;\n"
                  for i in range(25))
    bad = [f"class A {{\n public:\n{many}}};\n", f"struct A : B {{\n{inline}}};\n",
           "int x;\n" * 501]
    good = [f"class A {{\n{few}}};\n", f"// Many methods: one a pin.\nclass A {{\n{many}}};\n",
            "// Long file: one table.\n" + "int x;\n" * 501,
            f"struct A {{\n{few}  struct B {{\n{few}  }};\n}};\n"]
    blind = [text[:60] for text in bad if not check({"core/a.h": text}, options)]
    return blind + [f"that this is fine: {t[:40]}" for t in good
                    if check({"core/a.h": t}, options)]
