"""Below tools no object needs a heap, exceptions, OpenCV or the C library's mathematics.

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
# Why an exception stands: delete needs a reason beside it.
EXCEPT = {}


def findings_of(objects, name_of):
    if not objects:
        return []
    listed = subprocess.run(["nm", "-AC", *map(str, objects)], check=True, capture_output=True,
                            text=True).stdout
    findings = []
    for line in listed.splitlines():
        # file.o:[address] type symbol; U undefined, w/v weak, others are defined here.
        match = re.match(r"(.*?\.o):\s*[0-9a-f]*\s+(\w)\s+(.*)$", line)
        if not match:
            continue
        path, _, symbol = match.groups()
        symbol = symbol.split("@")[0]
        for what, pattern in FORBIDDEN.items():
            if pattern.search(symbol) and (name_of(path), symbol) not in EXCEPT:
                findings.append(f"{name_of(path)}:1: needs {symbol} ({what})")
    return findings


def check(tree, options):
    root = Path(options.objects)
    sources = [p for p in tree if p.endswith(".cc")
               and p.startswith(("core/", "modules/", "bsp/", "board/"))
               and not re.search(r"_(test|bench)\.cc$", p)]
    objects = [root / p.replace(".cc", ".o") for p in sources]
    return findings_of([o for o in objects if o.exists()],
                       lambda o: str(Path(o).relative_to(root).with_suffix(".cc")))


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
    return ([symbol for symbol in seen if f"needs {symbol}" not in found]
            + [f"that this is fine: {finding}" for finding in findings_in(good, options)])


def findings_in(source, options):
    out = Path(options.work) / "symbols_self_test.o"
    subprocess.run(["g++", "-std=c++17", "-O1", "-fno-math-errno", "-xc++", "-", "-c", "-o", out],
                   input=source, text=True, check=True)
    return findings_of([out], str)
