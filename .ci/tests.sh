# .ci/tests.sh: which tests stand for the others. Sourced.

# Pictures, by ctest's names: every engine, every feature of the march, every kind of ray, light and surface once; levels
# mixed, memory short, a frame after another, and a window's pictures by the native engine.
one_a_feature='^(prepare_test_stores$|Engines\.|Planes\.|Features\.|Gradients\.TheScenesChoice|Isosurfaces\.CompositeInOrder'
one_a_feature+='|Isosurfaces\.ThinSheets|Visibility\.MarchCounts|BlockRanges\.|NativeBlocks\.|NativeTypes\.|NativeBorders\.'
one_a_feature+='|Passes\.|Cuts\.|Frames\.|Renderers\.|Engines/Symmetries\.|Unfolded\.|LitPlanes\.|Emission\.|MaxError\.|Determinism\.|Gates\.|Framing\.'
one_a_feature+='|Occluder\.|LightPicture\.(NativeIsTheMirrorWhere|KeepsItsBudgets|FollowsAnEdit|Cuts)|MeasuredErrors\.|[A-Za-z]+/Interactive[A-Za-z]*\..*/native'
# Parts of a picture alone: formulas, sums, counts and choices, most of them below a second. ctest bears few parentheses.
one_a_feature+='|(AreaPicture|AutomaticIntegrator|AutomaticSamples|BestLevels|CutNothing|CutScissors|Cuts/CutRay|DeepShadowMap|DistanceMap'
one_a_feature+='|FirstPicture|GradedCulling|GradedNothing|GradedVisibility|IntegratorBound|LevelsWithin|MirrorAgainstReference|NativeLevels'
one_a_feature+='|NativeSurfaceHits|NativeVisibility|Occupancy|Phases|PictureErrors|PixelPlaces|RayArray|ReferenceThroughStore|RenderBudget'
one_a_feature+='|ShownRanges|SlicePoses|SphereDirections|SurfaceTracer|Texels|ValueWindow)\.|Gradients\.[ACHNSZ]|ReferenceLight\.[OSL]'
one_a_feature+='|SurfaceLight\.[A-HRT]|SurfaceReference\.Sides|MixedLevels\.[NO]|MixedLevels\.ValuesStay|MixedLevels\.Empty|Stiff\.Boundary'
one_a_feature+='|Places\.AreCharged|Places\.[NO]|SampledPictures\.[CN]|Isosurfaces\.AS|Isosurfaces\.All|Isosurfaces\.Occupy|ShadowMaps\.LookFrom'
one_a_feature+='|LightPicture\.[CDW]|Skipping\.RefiningIs|Interactive\.ThePaths|Interactive\.ADamaged)'
# What engines have in common with the mirror, on one of the scans' stores.
one_store='^[A-Za-z]+/(Contract|CutPicture|Values|Graded|Native|NativeSurfaces|NativeMixed|Gates|MixedPicture)\..*/torso'

# Test programs of a file that changed: of its room.
tests_of() { # FILE
    case $1 in
    core/image/*picture* | core/image/image_file* | tests/core/image/*) echo core_test core_image_file_test ;;
    core/* | tests/core/*) echo core_test core_scene_test ;;
    bricking/store/* | bricking/statistics/* | bricking/import/importer*) echo bricking_store_test ;;
    bricking/cache/*) echo bricking_cache_test ;;
    bricking/levels/*) echo bricking_selection_test ;;
    bricking/analysis/*) echo bricking_lumen_test bricking_body_test ;;
    bricking/import/* | tests/bricking/import/*) echo import_test damage_corpus ;;
    datasets/* | tests/datasets/*) echo datasets_phantom_test ;;
    tests/bricking/*) echo bricking_store_test bricking_cache_test ;;
    render/backends/native/* | render/contract/*) echo render_native_test ;;
    render/* | tests/render/*) echo render_unit_test render_engine_test ;;
    viewer/presets/*) echo viewer_presets_test ;;
    viewer/cli/modules/*) echo modules_test ;;
    esac
}
