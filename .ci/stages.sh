# .ci/stages.sh: for .ci/run and .ci/full: says when a stage begins, and at the end what each took. Sourced.
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
