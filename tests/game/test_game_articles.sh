#!/usr/bin/env bash
# test_game_articles.sh PROGRAM BENCH PAGE: checks that --help knows every `stilb ...` command line in PAGE, which is
# docs/articles.md, with its flags, plots, strips of spheres and bench suites.
set -euo pipefail
program=$1 bench=$2 page=$3
failures=0 commands=0
fail() {
	echo "$page: \`$1\`: $2"
	failures=$((failures + 1))
}
plots=$("$program" shade list)
while read -r line; do
	commands=$((commands + 1))
	read -r -a word <<<"$line"
	case ${word[1]} in
	shade | trace) help=$("$program" "${word[1]}" "${word[2]}" --help) || fail "$line" "no such part" ;;
	bench) help=$("$bench" --help) && grep -q "^  ${word[2]} " <<<"$help" || fail "$line" "no such suite" ;;
	*) help=$("$program" "${word[1]}" --help) || fail "$line" "no such command" ;;
	esac
	for ((i = 2; i < ${#word[@]}; i++)); do
		[[ ${word[i]} != --* ]] || grep -q -- "^  ${word[i]} " <<<"$help" || fail "$line" "--help does not know ${word[i]}"
		[[ ${word[i - 1]} != plot ]] || grep -q "^  ${word[i]} " <<<"$plots" || fail "$line" "no such plot"
		[[ ${word[i - 1]} != --strip ]] || grep -q "^  ${word[i]} " <<<"$help" || fail "$line" "no such strip"
	done
done < <(grep -o '`stilb [^`]*`' "$page" | tr -d '`')
[ $commands -ge 30 ] || { echo "$page: only $commands commands"; exit 1; }
[ $failures -eq 0 ] && echo "$commands commands are known to --help"
