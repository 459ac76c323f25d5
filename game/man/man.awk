# man.awk: turns the output of `stilb COMMAND --help` into a manual page, so that both come from the same tables of flags.
#   stilb render --help | awk -v page=stilb-render -v version=0.2.0 -v others="stilb stilb-demo ..." -f man.awk
function roff(text) {
	gsub(/\\/, "\\e", text)
	gsub(/-/, "\\-", text)
	sub(/^[.']/, "\\\\\\&&", text)
	return text
}
function section(title) { print ".SH " title; first = 1 }
# The opening paragraph, "CALL: PURPOSE", with CALL the usage of the command.
function opening(text,   at, called, does, brief) {
	at = index(text, ": ")
	called = at ? substr(text, 1, at - 1) : page
	does = at ? substr(text, at + 2) : text
	if (page == "stilb") { does = text; called = "stilb COMMAND [FLAGS]" }
	brief = does
	sub(/[.;:] .*|\.$/, "", brief)
	sub(/^Stilb [0-9.]+, /, "", brief)
	print ".TH " toupper(roff(page)) " 1 \"\" \"Stilb " version "\" \"Stilb\""
	section("NAME")
	print roff(page " - " tolower(substr(brief, 1, 1)) substr(brief, 2))
	section("SYNOPSIS")
	if (called !~ /FLAGS/) called = called " [FLAGS]"
	print ".B " roff(called)
	section("DESCRIPTION")
	print roff(toupper(substr(does, 1, 1)) substr(does, 2))
}
# A line "  NAME   TEXT"; two or more blanks separate TEXT.
function item(line,   name, text) {
	sub(/^ +/, "", line)
	name = line; text = ""
	if (match(line, /  +/)) { name = substr(line, 1, RSTART - 1); text = substr(line, RSTART + RLENGTH) }
	else if (line ~ /^-[^ ]+ [^ ]+ [a-z]/) { # a flag too long for its column
		match(line, /^-[^ ]+ [^ ]+/)
		name = substr(line, 1, RLENGTH); text = substr(line, RLENGTH + 2)
	}
	print ".TP\n.B " roff(name) "\n" roff(text)
}
!opened && (/^ / || /^$/) && words != "" { opening(words); opened = 1 }
!opened { words = words (words == "" ? "" : " ") $0; next }
/^usage: / { next }
/^$/ { gap = 1; next }
/^  +-/ && !options { section("OPTIONS"); options = 1; if (title != "") { print ".SS " roff(title); title = "" } }
/^[A-Z][^.]*:$/ { sub(/:$/, ""); if (options) print ".SS " roff($0); else title = $0; gap = 0; next }
/^ / { if (title != "") { print ".SS " roff(title); title = "" } item($0); gap = 0; next }
{ if (title != "") { print ".SS " roff(title); title = "" } if (gap) print ".PP"; print roff($0); gap = 0 }
END {
	if (!opened) opening(words)
	section("EXIT STATUS")
	if (page == "stilb-trace-diff")
		print ".TP\n.B 0\nno zone is slower\n.TP\n.B 1\na zone is slower\n.TP\n.B 2\nan error, before it started or later"
	else
		print ".TP\n.B 0\ndone\n.TP\n.B 1\nfailed while it ran\n.TP\n.B 2\nrefused before it started: a wrong flag, file or device"
	if (page == "stilb") {
		section("ENVIRONMENT")
		print ".TP\n.B STILB_ISA\n" roff("scalar, avx2 or avx512: the instruction set that culling uses (the best one)")
		print ".TP\n.B STILB_IMPORT_SECONDS\n" roff("seconds after which reading a scene file is given up (120)")
	}
	section("SEE ALSO")
	n = split(others, other, " ")
	for (i = 1; i <= n; i++)
		if (other[i] != page) list = list (list == "" ? "" : ",\n") ".BR " roff(other[i]) " (1)"
	print list
}
