# SPDX-License-Identifier: Apache-2.0
# Completes command lines of malha in fish. The program itself says what may follow.
function __malha_completions
    set -l words (commandline -opc)
    set -l last (commandline -ct)
    type --quiet $words[1]; and $words[1] __complete $words[2..-1] "$last" 2>/dev/null
end
complete -c malha -f -a '(__malha_completions)'
