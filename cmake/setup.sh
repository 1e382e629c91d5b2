# cmake/setup.sh: for demo.sh, test.sh and .ci/run: installs what is missing, configures and builds.
# Sourced with `root` set to the repository's folder. Quick when nothing is to do.

# Prints the packages of a list that are missing. A line is "package" or "package command".
missing_packages() {
    local package command
    while read -r package command; do
        [[ -z $package || $package == \#* ]] && continue
        if [[ -n $command ]]; then
            command -v "$command" >/dev/null || echo "$package"
        elif ! grep -q "^$package installed\$" <<<"$installed"; then
            echo "$package"
        fi
    done <"$1"
}

# Installs what the lists name and is missing: as root or through sudo without a password; else says how.
ensure_packages() {
    local installed="" list missing=() sudo=()
    if command -v dpkg-query >/dev/null; then
        installed=$(dpkg-query -W -f='${Package} ${db:Status-Status}\n${Package}:${Architecture} ${db:Status-Status}\n')
    fi
    for list in "$@"; do
        mapfile -t -O "${#missing[@]}" missing < <(missing_packages "$list")
    done
    [[ ${#missing[@]} -eq 0 ]] && return
    if ((EUID != 0)); then sudo=(sudo -n); fi
    if ! command -v apt-get >/dev/null || { ((EUID != 0)) && ! sudo -n true 2>/dev/null; }; then
        echo "These packages (Debian 12 names) are missing:" >&2
        printf '    %s\n' "${missing[@]}" >&2
        echo "Install them, for example with:" >&2
        echo "    sudo apt-get install --no-install-recommends ${missing[*]}" >&2
        exit 1
    fi
    echo "Installing ${#missing[@]} packages: ${missing[*]}" >&2
    "${sudo[@]}" apt-get update -q >&2
    "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get install -q -y --no-install-recommends "${missing[@]}" >&2
}

# For ccache, where it is installed: files by their place in the repository, so that another clone finds them.
export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1

# Configures preset release. Arguments: parts that are built besides the program, such as TESTS.
configure_release() {
    local options=() part log cache=$root/build/release/CMakeCache.txt
    for part in "$@"; do
        grep -qs "^TESSERA_WITH_$part:BOOL=ON" "$cache" || options+=("-DTESSERA_WITH_$part=ON")
    done
    [[ -f $root/build/release/build.ninja && ${#options[@]} -eq 0 ]] && return
    echo "Configuring ..." >&2
    log=$(mktemp)
    if ! (cd "$root" && cmake --preset release ${options[@]:+"${options[@]}"}) >"$log" 2>&1; then
        cat "$log" >&2
        rm -f "$log"
        exit 1
    fi
    rm -f "$log"
}

# The same, with every warning an error.
configure_strictly() {
    local parts=("${@/#/-DTESSERA_WITH_}")
    (cd "$root" && cmake --preset release -DCMAKE_COMPILE_WARNING_AS_ERROR=ON "${parts[@]/%/=ON}" >/dev/null)
}

# Builds preset release; arguments: targets (none: everything). Silent unless something is built or fails.
build_release() {
    local targets=()
    (($#)) && targets=(--target "$@")
    # ninja -n: is there anything to do? Only then is it worth a word.
    if ! (cd "$root/build/release" && ninja -n ${targets[@]:+"${targets[@]:1}"}) 2>/dev/null |
        grep -q "no work to do"; then
        echo "Building (some minutes the first time) ..." >&2
        (cd "$root" && cmake --build --preset release ${targets[@]:+"${targets[@]}"}) >&2
    fi
}
