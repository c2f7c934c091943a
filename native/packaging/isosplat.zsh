#compdef isosplat
# Completion of isosplat for zsh. Subcommands and options come from --help, so they are those of the
# installed program.
local command
local -a names
command=${${words[2,CURRENT-1]:#-*}[1]}
if [[ $PREFIX == -* ]]; then
  names=(${(f)"$(isosplat $command --help 2>/dev/null | grep -oE '(^|[ ,])--?[a-z][a-z-]*' | tr -d ' ,')"})
  compadd -- $names
elif [[ -z $command ]]; then
  names=(${(f)"$(isosplat --help 2>/dev/null | sed -n '/^[Ss]ubcommands:/,/^[^ ]/s/^  \([a-z-]*\) .*/\1/p')"})
  compadd -- $names
else
  _files
fi
