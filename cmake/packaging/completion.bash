# Completes command lines of lodestream and lodestreamd in bash: commands, options, values and files, as --help of the program
# describes them.

# Prints the commands of a program, from its help.
_lodestream_commands() {  # HELP
  awk 'tolower($1) ~ /^subcommands:$/ { is_listed = 1; next } is_listed && /^  [a-z]/ { print $1 }' <<<"$1"
}

# Prints a line per option or positional argument: its names, separated by commas, and the value that it takes. The name of a
# positional argument is "positional".
_lodestream_arguments() {  # HELP
  awk '
    /^[A-Za-z]+:$/ { is_positional = tolower($1) == "positionals:"; next }
    /^ +-/ {
      sub(/^ +/, "")
      sub(/, +-/, ",-")
      names = $1
      value = index($0, names " ") == 1 && substr($0, length(names) + 2, 1) != " " ? $2 : ""
      print names, value == "Excludes:" ? "" : value
    }
    is_positional && /^  [a-z]/ { print "positional", $2 }' <<<"$1"
}

# Prints the value of an option or positional argument.
_lodestream_value() {  # HELP NAME
  _lodestream_arguments "$1" | awk -v name="$2" 'index("," $1 ",", "," name ",") { print $2; exit }'
}

# Prints the files that begin with the word and have one of the endings, and the folders on the way to them.
_lodestream_files() {  # WORD [ENDING...]
  local file ending
  compgen -d -- "$1"
  while IFS= read -r file; do
    [[ ! -d "$file" ]] || continue
    for ending in "${@:2}"; do
      [[ "${file,,}" != *".$ending" ]] || echo "$file"
    done
    [[ $# -gt 1 ]] || echo "$file"
  done < <(compgen -f -- "$1")
}

# Prints the words that a value may have.
_lodestream_words() {  # WORD VALUE
  local choices
  case "$2" in
    *\{*\}*)
      choices="${2#*\{}"
      compgen -W "${choices%%\}*}" -- "$1"
      ;;
    'y|z|x|-y|-z|-x') compgen -W "y z x -y -z -x" -- "$1" ;;
    DIR*) compgen -d -- "$1" ;;
    IN.ply) _lodestream_files "$1" ply ;;
    TARGET) _lodestream_files "$1" lode ply json ;;
    STORE*) _lodestream_files "$1" lode ;;
    FILE* | TEXT* | *.*) _lodestream_files "$1" ;;
  esac
}

_lodestream() {  # PROGRAM WORD PREVIOUS
  local IFS=$' \t\n' word="$2" previous="$3" command="" help value position
  help="$("$1" --help 2>/dev/null)" || return 0
  for ((position = 1; position < COMP_CWORD; position++)); do
    case "${COMP_WORDS[position]}" in -*) continue ;; esac
    command="${COMP_WORDS[position]}"
    break
  done
  # bash splits --option=value into three words.
  if [[ "$word" == "=" ]]; then word=""; elif [[ "$previous" == "=" ]]; then previous="${COMP_WORDS[COMP_CWORD - 2]}"; fi
  if [[ -n "$command" ]]; then
    # A first word that is no command is the target of the client's command view.
    grep -qx -- "$command" <<<"$(_lodestream_commands "$help")" || command=view
    help="$("$1" "$command" --help 2>/dev/null)" || return 0
  fi

  value=""
  [[ "$previous" != -* ]] || value="$(_lodestream_value "$help" "$previous")"
  if [[ -z "$value" && "$word" == -* ]]; then
    value="{$(_lodestream_arguments "$help" | cut -d ' ' -f 1 | grep '^-' | tr ',' '\n' | tr '\n' ' ')}"
  elif [[ -z "$value" && -z "$command" ]]; then
    value="{$(_lodestream_commands "$help" | tr '\n' ' ')}"
    if [[ "$value" == *view* && -z "$(_lodestream_words "$word" "$value")" ]]; then value=TARGET; fi
  elif [[ -z "$value" ]]; then
    value="$(_lodestream_value "$help" positional)"
  fi
  [[ "$value" != *\{*,*\}* ]] || value="${value//,/ }"
  mapfile -t COMPREPLY < <(_lodestream_words "$word" "$value")
  [[ "$value" == *\{* ]] || compopt -o filenames 2>/dev/null || true
}

complete -F _lodestream lodestream lodestreamd
