# .ci/stages.sh: for .ci/run and .ci/full: says when a stage begins, at the end what each took, and keeps what passed.
# Sourced.
stages=()
stage_began=$SECONDS

# The stage before ends, and this one begins.
stage() {
    [[ -n ${stage_name:-} ]] && stages+=("$(printf '%6d s  %s' $((SECONDS - stage_began)) "$stage_name")")
    stage_name=$1 stage_began=$SECONDS
    [[ -z $1 ]] || echo "== $1"
}
say_stages() {
    stage ""
    printf '%s\n' "${stages[@]}"
}

as_committed() { git diff --quiet HEAD; }
# Keeps in .ci/checked that this commit passed: what .ci/run finds nothing in, later changes are compared with.
keep_as_passed() { # WHAT...: full, run
    local what
    as_committed || return 0
    for what in "$@"; do
        sed -i "s/^$what .*/$what $(git rev-parse HEAD)/" .ci/checked
    done
}
