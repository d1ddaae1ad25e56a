# Functions that install packages into the environment in $folder, with output in $log: by its pip,
# or by the uv of .venv. setup.sh and install_into.sh read them.

# Run a command with its output in the log; a terminal shows its last step.
run() {
    "$@" >>"$log" 2>&1 </dev/null &
    job=$!
    trap 'kill "$job" 2>/dev/null; exit 130' INT TERM
    if [ -t 1 ]; then
        while kill -0 "$job" 2>/dev/null; do
            step=$(grep -E '^ *(Collecting|Download|Building|Built|Resolved|Prepared|Install)' "$log" |
                tail -n 1)
            printf '\r\033[K  %.70s' "${step#"${step%%[! ]*}"}"
            sleep 1
        done
        printf '\r\033[K'
    fi
    wait "$job"
}

with_pip() {
    run "$folder/bin/python" -m pip install --disable-pip-version-check "$@"
}

with_uv() {
    # shellcheck disable=SC2086  # none or one flag
    run .venv/bin/uv pip install --python "$folder/bin/python" $no_index "$@"
}

# Print a setting of pip: of its variables, else of its files.
pip_setting() {
    for section in :env: install global; do
        value=$(printf '%s\n' "$settings" | sed -n "s/^$section\.$1='\(.*\)'\$/\1/p")
        if [ -n "$value" ]; then
            printf '%s\n' "$value" | sed 's/\\n/ /g; s/^ *//'
            return
        fi
    done
}

# Hand over to uv where pip looks for packages: uv reads neither pip's files nor its variables.
configure_uv() {
    settings=$(.venv/bin/python -m pip config list)
    while read -r name variable; do
        value=$(pip_setting "$name")
        eval "present=\${$variable:-}"
        [ -n "$present" ] || [ -z "$value" ] || export "$variable=$value"
    done <<END
index-url UV_DEFAULT_INDEX
extra-index-url UV_INDEX
find-links UV_FIND_LINKS
trusted-host UV_INSECURE_HOST
cert SSL_CERT_FILE
proxy ALL_PROXY
END
    case $(pip_setting no-index) in
        1 | [Tt]rue | [Yy]es | [Oo]n) no_index=--no-index ;;
        *) no_index= ;;
    esac
    export UV_INDEX_STRATEGY="${UV_INDEX_STRATEGY:-unsafe-best-match}" # as pip: all indexes alike
}
