#!/usr/bin/env bash
# Prints the man page of a program, made from the program's --help: make_man_page.sh PROGRAM VERSION TAIL
# TAIL is a file with the sections that --help lacks, in the language of man pages. The page contains no date, so that it depends
# on nothing else.
set -euo pipefail

program="$1" version="$2" tail="$3"
name="$(basename "$program")"

# Functions for awk.
escape='
# Returns a line as text of a man page: escapes backslashes, dashes, and a point or a quote in front.
function plain(text) {
  gsub(/\\/, "\\e", text)
  gsub(/-/, "\\-", text)
  if (text ~ /^[.\047]/) text = "\\&" text
  return text
}
# Returns the type of a value in short: "UINT:UINT in [1 - 9]" becomes "N in [1 - 9]".
function short(value) {
  gsub(/:(UINT|FLOAT|DIR|FILE)/, "", value)
  gsub(/UINT|FLOAT/, "N", value)
  gsub(/TEXT:/, "", value)
  return value
}
'

# Prints the first lines of --help, up to "Usage:", as one paragraph each.
description() { awk "$escape"'/^Usage:/ { exit } NF { print ".PP"; print plain($0) }' <<<"$1"; }

# Prints the entries of a section of --help, such as Positionals. An entry is a line with a name and maybe its text; lines that
# are indented further continue the text.
entries() {  # HELP
  awk "$escape"'
    /^[A-Z][A-Za-z]*:$/ { is_listed = ($1 ~ /^(Positionals|Options|POSITIONALS|OPTIONS):$/); next }
    { sub(/ +$/, "") }
    /^\[Option Group/ { is_listed = is_group = 1; next }
    is_group && NF { sub(/^ */, ""); print ".PP\n" plain($0); is_group = 0; next }
    !is_listed || !NF || /^ *Options:$/ || /^ *\[/ { next }
    match($0, /^ */) && RLENGTH >= 20 { sub(/^ */, ""); print plain($0); next }
    {
      sub(/^ */, "")
      text = ""
      head = $0
      sub(/^-[A-Za-z], *-/, "&\001", head)  # the blanks between a short and a long name separate no text
      if (match(head, /  +/)) {
        text = substr(head, RSTART + RLENGTH)
        head = substr(head, 1, RSTART - 1)
      }
      gsub(/\001/, "", head)
      sub(/, *-/, ", -", head)
      name = head
      sub(/ [^-].*/, "", name)
      value = short(substr(head, length(name) + 1))
      print ".TP"
      print "\\fB" plain(name) "\\fR" plain(value)
      if (text != "") print plain(text)
    }' <<<"$1"
}

commands() { awk '/^Subcommands:/ { is_listed = 1; next } is_listed && /^  [a-z]/ { print $1 }' <<<"$1"; }

help="$("$program" --help)"
summary="$(head -1 <<<"$help")"
summary="${summary%.}"
echo ".\\\" Made by cmake/packaging/make_man_page.sh from $name --help."
echo ".TH ${name^^} 1 \"\" \"$name $version\" \"Lodestream\""
echo ".SH NAME"
awk "$escape"'{ print plain($0) }' <<<"$name" | tr '\n' ' '
awk "$escape"'{ print "\\- " plain($0) }' <<<"$summary"
echo ".SH SYNOPSIS"
echo "\\fB$name\\fR \\fICOMMAND\\fR [\\fIOPTIONS\\fR]"
echo ".SH DESCRIPTION"
description "$help"
echo ".SH OPTIONS"
entries "$help"
echo ".SH COMMANDS"
for command in $(commands "$help"); do
  of_command="$("$program" "$command" --help)"
  echo ".SS $(awk "$escape"'/^Usage:/ { sub(/^Usage: [^ ]* /, ""); print plain($0) }' <<<"$of_command")"
  description "$of_command"
  entries "$of_command"
done
cat "$tail"
