"""Below tools no object needs a heap, exceptions, OpenCV or the C library's mathematics; an image
of a board without an operating system holds none of these, nor the C library's input and output.

The C library's sin, exp ... differ in the last bit from machine to machine; core/math/trig.h is the
same everywhere.
"""
import re
import subprocess
from pathlib import Path

FORBIDDEN = {
    "heap": re.compile(
        r"^(malloc|calloc|realloc|free|aligned_alloc|posix_memalign|strdup)$"
        r"|^operator (new|delete)"),
    "exceptions": re.compile(r"^(__cxa_throw|__cxa_allocate_exception|__cxa_rethrow)$"),
    "OpenCV": re.compile(r"\bcv::"),
    "libm, not the same bits everywhere": re.compile(
        r"^(a?(sin|cos|tan)h?|atan2|sincos|exp|exp2|expm1|log|log2|log10|log1p|pow|hypot|cbrt|fma)"
        r"f?$"),
}
# Of a linked image alone: bsp/linux is made of these.
FORBIDDEN_IN_IMAGE = {
    "C library I/O": re.compile(
        r"^_?(v?[fsd]?n?(printf|scanf)|f?put[sc]|putchar|f?get[sc]|f(open|close|read|write|flush)"
        r"|open|close|read|write|lseek|sbrk|stdin|stdout|stderr)$"),
}
# Why an exception stands: delete needs a reason beside it.
EXCEPT = {}


def findings_of(objects, name_of, forbidden=None):
    if not objects:
        return []
    listed = subprocess.run(["nm", "-AC", *map(str, objects)], check=True, capture_output=True,
                            text=True).stdout
    findings = []
    for line in listed.splitlines():
        # file.o:[address] type symbol; U undefined, w/v weak, others are defined here.
        match = re.match(r"(.*?\.(?:o|elf)):\s*[0-9a-f]*\s+(\w)\s+(.*)$", line)
        if not match:
            continue
        path, _, symbol = match.groups()
        symbol = symbol.split("@")[0]
        for what, pattern in (forbidden or FORBIDDEN).items():
            if pattern.search(symbol) and (name_of(path), symbol) not in EXCEPT:
                findings.append(f"{name_of(path)}:1: needs {symbol} ({what})")
    return findings


def check(tree, options):
    sources = [p for p in tree if p.endswith(".cc")
               and p.startswith(("core/", "modules/", "bsp/", "board/"))
               and not re.search(r"_(test|bench)\.cc$", p)]
    findings = []
    for root in map(Path, options.objects):
        objects = [root / p.replace(".cc", ".o") for p in sources]
        found = findings_of([o for o in objects if o.exists()],
                            lambda o, root=root: str(Path(o).relative_to(root).with_suffix(".cc")))
        findings += [finding for finding in found if finding not in findings]
    return findings + findings_of(options.image, str, {**FORBIDDEN, **FORBIDDEN_IN_IMAGE})


def self_test(options):
    bad = """
        #include <cmath>
        #include <cstdlib>
        namespace cv { void imread(); }
        extern "C" __attribute__((weak)) void free(void*);
        void* f1(int n) { return std::malloc(n); }
        int* f2(int n) { return new int[n]; }
        void f3(int* p) { delete p; }
        void f4() { throw 1; }
        void f5() { cv::imread(); }
        void f6(void* p) { free(p); }
        double f7(double x) { return std::sin(x); }
        float f8(float x) { return std::pow(x, 0.3f); }
    """
    seen = ["malloc", "operator new[]", "operator delete", "__cxa_throw", "cv::imread", "free",
            "sin", "powf"]
    good = "#include <cmath>\ndouble f(double x) { return std::floor(std::sqrt(x)); }"
    found = "".join(findings_in(bad, options))
    io = "#include <cstdio>\nvoid f() { std::puts(\"\"); std::fflush(stdout); }"
    seen_io = ["puts", "fflush", "stdout"]
    found_io = "".join(findings_in(io, options, FORBIDDEN_IN_IMAGE))
    seen += [symbol for symbol in seen_io if f"needs {symbol} " not in found_io]
    return ([symbol for symbol in seen if f"needs {symbol}" not in found]
            + [f"that this is fine: {finding}" for finding in findings_in(good, options)])


def findings_in(source, options, forbidden=None):
    out = Path(options.work) / "symbols_self_test.o"
    subprocess.run(["g++", "-std=c++17", "-O1", "-fno-math-errno", "-xc++", "-", "-c", "-o", out],
                   input=source, text=True, check=True)
    return findings_of([out], str, forbidden)
