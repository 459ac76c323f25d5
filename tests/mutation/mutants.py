#!/usr/bin/env python3
"""Random mutants: one small change of meaning in each of N functions drawn from all modules. Does a test fail?

    mutants.py draw [--seed HASH] [--count 130] > mutants.txt
    mutants.py run mutants.txt --tree WORKTREE [--count 100] [--only ID,...] [--tiers unit,device,window]

draw prints one line per mutant: ID, FILE:LINE, FUNCTION, OPERATOR, and the line before and after. The seed is a commit's hash, so
that nobody chooses the mutants; without --seed it is that of HEAD^. Functions are drawn uniformly from the C files
of jobs, profiler, engine and game, examples aside; a function without a place for any operator is drawn again.

run applies one mutant after the other in WORKTREE, a checkout of the same commit with a configured build/release. It
builds and runs the tests of the mutant's module, then all tests of the tiers, and prints KILLED with the test's name, SURVIVED,
or BROKEN when it does not compile; it ends when --count mutants compiled, so draw some more. Run the tests without a mutant
first: only a test that passes then may kill one.

Operators, each applied to one place outside comments, strings and asserts:
    relation   < and <=, > and >=, == and != change places
    logic      && and || change places
    negate     if (c) and while (c) become if (!(c)), while (!(c))
    arithmetic + and -, * and /, += and -=, << and >> change places
    constant   an integer n becomes n + 1; 0 becomes 1; a float f becomes f * 1.5
    truth      true and false change places
    bound      min and max, fminf and fmaxf and their like change places
    drop       a statement that is a call or an assignment, alone on its line, is left out
    early      a value returned: return e becomes return 0 (or NULL or false), return 0 becomes return 1
    order      memory_order_release, _acquire, _acq_rel and _seq_cst become memory_order_relaxed
"""
import argparse
import os
import random
import re
import subprocess
import sys
import time

FOLDERS = ("jobs", "profiler", "engine", "game")
MODULE = {"jobs": "jobs", "profiler": "profiler", "game": "game"}
TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def git(*words, cwd=TOP):
    return subprocess.run(["git", *words], cwd=cwd, check=True, capture_output=True, text=True).stdout.strip()


def module_of(path):
    part = path.split("/")
    if part[0] == "engine":
        return part[1] if len(part) > 2 else "engine"
    return MODULE[part[0]]


def blank(text):
    """The text with comments, strings, characters and asserts overwritten by spaces; every place keeps its column."""
    def spaces(match):
        return re.sub(r"[^\n]", " ", match[0])
    text = re.sub(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', spaces, text, flags=re.S)
    text = re.sub(r"^[ \t]*#[^\n]*(?:\\\n[^\n]*)*", spaces, text, flags=re.M)
    return re.sub(r"\b(?:STILB_ASSERT\w*|STILB_CHECK|static_assert|assert)\s*\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\)\s*;", spaces,
                  text, flags=re.S)


def functions(text):
    """(name, begin, end) of each function body; clang-format puts its braces into the first column."""
    for match in re.finditer(r"^(?![ \t#}/*]|typedef|struct|enum|union)([^\n;={}]*\([^;{}]*\))\n\{\n(.*?)^\}", text, re.M | re.S):
        name = re.search(r"(\w+)\s*\(", match[1])
        if name:
            yield name[1], match.start(2), match.end(2)


SWAPS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||", "||": "&&", "+": "-", "-": "+",
         "*": "/", "/": "*", "+=": "-=", "-=": "+=", "<<": ">>", ">>": "<<", "true": "false", "false": "true"}
BOUNDS = {"min": "max", "max": "min", "fmin": "fmax", "fmax": "fmin", "fminf": "fmaxf", "fmaxf": "fminf", "least": "most"}


def places(body):
    """(operator, begin, end, replacement) for each change that can be made to a function's body."""
    for match in re.finditer(r"(?<=\s)(<=|>=|==|!=|<|>)(?=\s)", body):
        yield "relation", match.start(), match.end(), SWAPS[match[0]]
    for match in re.finditer(r"&&|\|\|", body):
        yield "logic", match.start(), match.end(), SWAPS[match[0]]
    for match in re.finditer(r"\b(?:if|while) \(((?:[^()]|\((?:[^()]|\([^()]*\))*\))*)\)", body):
        yield "negate", match.start(1), match.end(1), None # the words stand in the text, not in the blanked body
    for match in re.finditer(r"(?<=[\w)\]] )(\+=|-=|<<|>>|\+|-|\*|/)(?= [\w(&*~-])", body):
        yield "arithmetic", match.start(), match.end(), SWAPS[match[0]]
    for match in re.finditer(r"(?<![\w.\[])(\d+)(?![\w.xX])[uU]?(?![\w.])", body):
        yield "constant", match.start(1), match.end(1), str(int(match[1]) + 1)
    for match in re.finditer(r"(?<![\w.])(\d+\.\d+)(?=f?\b)", body):
        if float(match[1]) != 0.0:
            yield "constant", match.start(1), match.end(1), repr(float(match[1]) * 1.5)
    for match in re.finditer(r"\b(?:true|false)\b", body):
        yield "truth", match.start(), match.end(), SWAPS[match[0]]
    for match in re.finditer(r"\b(fminf|fmaxf|fmin|fmax|min|max)(?=\()", body):
        yield "bound", match.start(), match.end(), BOUNDS[match[0]]
    for match in re.finditer(r"^[ \t]+((?!return|break|continue|goto|else|case|default)[\w>.\[\]*-]+(?:\([^\n]*\)| [-+|&^*/]?= [^\n]*));$", body, re.M):
        if not re.match(r"\w+ \*?\w+ =", match[1]):
            yield "drop", match.start(1), match.end(1), "(void)0"
    for match in re.finditer(r"\breturn ([^;]+);", body):
        if match[1] not in ("true", "false") and "{" not in match[1]:
            yield "early", match.start(1), match.end(1), "1" if match[1] in ("0", "NULL") else "0"
    for match in re.finditer(r"memory_order_(?:release|acquire|acq_rel|seq_cst)\b", body):
        yield "order", match.start(), match.end(), "memory_order_relaxed"


def draw(seed, count):
    rng = random.Random(seed)
    pool = []
    for path in git("ls-files", *FOLDERS).split("\n"):
        if path.endswith(".c") and "/examples/" not in path:
            text = blank(open(os.path.join(TOP, path)).read())
            pool += [(path, name, begin, end) for name, begin, end in functions(text)]
    print(f"# seed {seed}, {len(pool)} functions", flush=True)
    rng.shuffle(pool)
    number = 0
    for path, name, begin, end in pool:
        text = open(os.path.join(TOP, path)).read()
        body = blank(text)[begin:end]
        kinds = {}
        for operator, a, b, new in places(body):
            kinds.setdefault(operator, []).append((begin + a, begin + b, new))
        if not kinds:
            continue
        operator = rng.choice(sorted(kinds))
        a, b, new = rng.choice(kinds[operator])
        if new is None:
            new = "!(" + text[a:b] + ")"
        if "\n" in new or "\t" in new:
            continue
        number += 1
        line = text.count("\n", 0, a) + 1
        changed = text[:a] + new + text[b:]
        before = text.split("\n")[line - 1].strip()
        after = changed.split("\n")[line - 1].strip()
        print("\t".join([str(number), f"{path}:{line}", name, operator, f"{a}:{b}:{new}", before, after]))
        if number == count:
            break


def call(command, cwd, limit):
    try:
        done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=limit)
        return done.returncode, done.stdout + done.stderr
    except subprocess.TimeoutExpired:
        return 124, ""


def first_failure(tree, selection, limit):
    """The first test of a selection that fails, or None."""
    code, said = call(["ctest", "--test-dir", "build/release", "-j2", "--stop-on-failure", "--timeout", "120", *selection], tree, limit)
    failed = re.findall(r"^\s*\d+ - (\S+) \((?:Failed|Timeout|SEGFAULT|Subprocess aborted|[^)]*)\)", said, re.M)
    failed = [name for name in failed if not name.startswith("test_tree_")]
    return failed[0] if failed else None


def run(list_file, tree, only, tiers, count):
    score = {"KILLED": 0, "SURVIVED": 0, "BROKEN": 0}
    for row in open(list_file):
        if row.startswith("#"):
            continue
        if score["KILLED"] + score["SURVIVED"] == count:
            break
        number, place, name, operator, change, before, after = row.rstrip("\n").split("\t")
        if only and number not in only:
            continue
        path = place.split(":")[0]
        a, b, new = change.split(":", 2)
        file = os.path.join(tree, path)
        text = open(file).read()
        begin = time.time()
        verdict, by = "SURVIVED", ""
        try:
            open(file, "w").write(text[:int(a)] + new + text[int(b):])
            module = module_of(path)
            code, said = call(["cmake", "--build", "build/release", "--target", f"stilb-tests-{module}"], tree, 900)
            if code == 0:
                by = first_failure(tree, ["-L", f"^module={module}$", "-LE", "model|truth|vm|fuzz|viewer" +
                                          "".join(f"|^{t}$" for t in ("device", "window") if t not in tiers)], 900)
                if not by:
                    code, said = call(["cmake", "--build", "build/release"], tree, 1500)
                    by = code == 0 and first_failure(tree, ["-L", "^(" + "|".join(tiers) + ")$"], 1800)
            if code != 0:
                verdict = "BROKEN"
            elif by:
                verdict = "KILLED"
        finally:
            open(file, "w").write(text)
        score[verdict] += 1
        print(f"{number}\t{verdict}\t{by or '-'}\t{place} {name} {operator}\t{before}  =>  {after}\t{time.time() - begin:.0f} s", flush=True)
    print("# " + ", ".join(f"{count} {word.lower()}" for word, count in score.items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parts = parser.add_subparsers(dest="part", required=True)
    drawing = parts.add_parser("draw")
    drawing.add_argument("--seed")
    drawing.add_argument("--count", type=int, default=130)
    running = parts.add_parser("run")
    running.add_argument("list")
    running.add_argument("--tree", required=True)
    running.add_argument("--only", default="")
    running.add_argument("--count", type=int, default=100)
    running.add_argument("--tiers", default="unit,device,window")
    words = parser.parse_args()
    if words.part == "draw":
        draw(words.seed or git("rev-parse", "HEAD^"), words.count)
    else:
        run(words.list, words.tree, set(filter(None, words.only.split(","))), words.tiers.split(","), words.count)


if __name__ == "__main__":
    sys.exit(main())
