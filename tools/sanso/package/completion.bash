# Completion of sanso for bash: commands and options as the program itself lists them.
_sanso() {
  local word=${COMP_WORDS[COMP_CWORD]} command=()
  local given
  for given in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    [[ $given == -* ]] && break
    command+=("$given")
  done
  local help
  help=$(sanso "${command[@]}" --help 2>/dev/null) || help=$(sanso "${command[0]}" --help 2>/dev/null)
  if [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(grep -oE -- '--[a-z][a-z-]*' <<< "$help" | sort -u)" -- "$word")
  else
    mapfile -t COMPREPLY < <(compgen -W "$(sed -n '/^Subcommands:/,$ s/^  \([a-z][a-z-]*\) .*/\1/p' <<< "$help")" -- "$word")
  fi
  [[ ${#COMPREPLY[@]} -gt 0 ]] || mapfile -t COMPREPLY < <(compgen -f -- "$word")
}
complete -o filenames -F _sanso sanso
