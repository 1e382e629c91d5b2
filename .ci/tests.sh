# .ci/tests.sh: which tests stand for the others. Sourced.

# Pictures, by ctest's names: every engine, every feature of the march, every kind of ray, light and surface once; levels
# mixed, memory short, a frame after another, and a window's pictures by the native engine.
one_a_feature='^(prepare_test_stores$|Engines\.|Planes\.|Features\.|Gradients\.TheScenesChoice|Isosurfaces\.CompositeInOrder'
one_a_feature+='|Isosurfaces\.ThinSheets|Visibility\.MarchCounts|BlockRanges\.|NativeBlocks\.|NativeTypes\.|NativeBorders\.'
one_a_feature+='|Passes\.|Cuts\.|Frames\.|Renderers\.|Engines/Symmetries\.|Unfolded\.|LitPlanes\.|Emission\.|MaxError\.|Determinism\.|Gates\.|Framing\.'
one_a_feature+='|Occluder\.|LightPicture\.(NativeIsTheMirrorWhere|KeepsItsBudgets|FollowsAnEdit|Cuts)|MeasuredErrors\.|[A-Za-z]+/Interactive[A-Za-z]*\..*/native)'
# Parts of a picture alone: formulas, sums, counts and choices, most of them below a second. Whole suites, then tests of
# suites whose others are slow. One list without parentheses: CMake's expressions bear few.
quick_suites=(
    AreaPicture AutomaticIntegrator AutomaticStep BadRays Cameras ExtremeCases ExtremeReference FusedCameras HostileNumbers ImportBudget IntegratorOrder LabelCamera LabelLooks LabelShows LabelTexels
    OutlineBands PlanePlaces SetReaders LightMemory LightTexel MeshShade OcclusionRoom PlacedLights Reflections LightMapPicture SceneLight VoxelLight ExtinctionBoundsOfScenes PathPicture PathRounds PathSurfaces Gammas/PathsOfContract PictureLayers AutomaticSamples BestLevels ChunkExtinctions CutNothing CutScissors Cuts/CutRay DeepShadowMap
    DistanceMap FirstHit FirstHitMap FirstHits FirstHitShadowsOfPictures FirstHitShadowsOfThinTissue Kinds/FirstHitShadows VarianceMap FirstPicture FusedBudgets FusedCuts FusedErrors FusedForms FusedGpu FusedLight FusedOcclusion FusedRefusals FusedSlices FusedValues Hulls Cameras/HullRays GradedCulling GradedNothing GradedVisibility HiddenLabelsOf HiddenTable HistogramLight IntegratorBound LabelBudgets
    LabelBorders LabelCells LabelForms LabelLevels LabelOptics LabelRefusals LevelsWithin Modes/HiddenLabels Of/MaxErrorScenes Scenes/Fused Scenes/Labelled
    Cameras/MeshCamera MeshCosts MeshEngines MeshErrors MeshInFog MeshLight MeshShadows
    Parts Scenes/PartsOf
    MirrorAgainstReference NativeLevels NativeSurfaceHits NativeVisibility Occupancy Phases PictureErrors PixelPlaces
    SplatFilters SplatFootprints SplatPictures TorsoSplats ValueLists
    NearestBorders RayArray ReferenceThroughStore RenderBudget Scatter SeveralInteractives ShownRanges SliceLabels SlicePoses SphereDirections SurfaceTracer Texels
    ValueWindow
)
quick_tests=(
    Engines/SliceOfDicom.IsTrilinearInterpolationOfItsValues/mirror
    Engines/SliceOfDicom.IsTrilinearInterpolationOfItsValues/native
    Engines/SliceOfDicom.IsTrilinearInterpolationOfItsValues/reference
    Integrators/Determinism.ThreadsChangeNoBit/linear Integrators/Determinism.ThreadsChangeNoBit/midpoint
    Integrators/Determinism.ThreadsChangeNoBit/preintegrated
    Integrators/Determinism.ThreadsChangeNoBit/preintegrated2d
    Frames/FramesOf.EqualStills/mirror Frames/FramesOf.EqualStills/native Frames/FramesOf.EqualStills/nativeGreatest
    Frames/FramesOf.EqualStills/nativeLight Frames/FramesOf.EqualStills/nativePasses
    Frames/FramesOf.EqualStills/nativePaths Frames/FramesOf.EqualStills/nativeSamples
    Frames/FramesOf.EqualStills/nativeShort Frames/FramesOf.EqualStills/nativeSurface
    Gradients.AnalyticOneIsTheDerivativeOfMixedLevels Gradients.AreExactForWhatTheirFormulaIs
    Gradients.CentralIsTrilinearBetweenTheDifferencesOfTheLattice
    Gradients.CubicIsSmoothAndConvolvesTheSamplesWithTheSpline Gradients.HaveTheirOrders
    Gradients.NormalsOfASphereAreRadialUnderAnySpacing Gradients.SobelIsThatOfTheNeighbouringSamples
    Gradients.ZeroIsUnlitAndNeverNan Interactive.ADamagedChunkIsToldOfOnce
    Interactive.ThePathsNextBricksAreLoadedAhead Isosurfaces.ASphereIsHitWhereARayMeetsIt
    Interactive.ComesToTheStillsLevelsAndPicture Interactive.FirstPictureIsWholeAndPicturesGetBetter
    Isosurfaces.AllCrossingsAreFoundWhateverTheStep Isosurfaces.CostNothingWhereThereAreNone
    Isosurfaces.NothingGrowsBehindAnOpaqueMedium Isosurfaces.NothingIsMetBeyondTheLastOfSteepEdges
    Isosurfaces.NothingIsSampledFarFromThem Isosurfaces.OccupyOnlyWhereTheyAre
    LightExtremes.AreFiniteAndBounded
    LightPicture.CostsNothingWhereItIsNotAskedFor LightPicture.CutsAndThreadsChangeNothing
    LightPicture.DarkensWhatIsHidden LightPicture.WhatIsBehindASurfaceTakesLight MixedLevels.EmptyCellsShowNothing
    MixedLevels.NearestBrickJumpsAtBorders MixedLevels.OneLevelIsPlainTrilinear
    MixedLevels.ValuesStayInTheHullOfTheirSamples Places.AreChargedWhereTheyAreKept
    Places.NativePicturesHaveTheMirrorsBits Places.NativeSurfacesAndHitsAreTheMirrors
    Places.OfTheReferenceAreThoseOfLargerPictures Places.WaitingRaysGoOnThroughTheirPlaces
    ReferenceLight.LightsAreWhereShadowMapsHaveThem
    ReferenceLight.OcclusionBesideAWall ReferenceLight.OcclusionInARisingMedium ReferenceLight.OcclusionInOneMedium
    ReferenceLight.OtherSums ReferenceLight.ReachesThePlaceWhereAShareIsLeft ReferenceLight.ShadowsInAnyVolume
    ReferenceLight.ShadowsOfASlab SampledPictures.ComeToTheMeanOfThePixel
    SampledPictures.AreTheSameOnEveryEngineAndHoweverTheyAreCut
    SampledPictures.NeedTheMemoryThatTheySay SampledScenes.APictureOfNothingIsMeasuredToo
    SampledScenes.AVolumeThatClipsThePicturesEdgeIsSampledLikeAnyOther
    SampledScenes.MaxErrorEndsWithTheFloorsMemory
    ShadowMaps.ARunIsPlaceByPlace ShadowMaps.BearExtremes ShadowMaps.BytesAreThoseOfTheMaps
    ShadowMaps.CastInPartsAreTheSame ShadowMaps.HoldTheBoxOfWhatShows
    ShadowMaps.OfAnEvenMediumAreItsClosedForm ShadowMaps.OfAnEvenMediumInAnyLattice
    ShadowMaps.OfSoftLightsAreTheMean ShadowMaps.OfSoftLightsLookFromItsDisk
    ShadowMaps.PointLightsHaveOneMapOrSix
    ShadowMaps.LookFromBeforeAPlace ShadowMaps.PacketsCastTheSameRays ShadowMaps.PacketsThatLackABrickLeaveTheRest
    Skipping.PicturesAreBitEqualWithEitherMap Skipping.RefiningIsLeftOutWhereItDoesNotPay
    StepOfMeans.IsLongerAndThePictureAsGood StepOfMeans.IsNotTakenWhereRaysHaveNoPhases
    Stiff.BoundaryLayer Stiff.BoundaryLayerOnGradedSegments Stiff.ColourRampInDouble Stiff.ColourRampInFloat
    SurfaceLight.ACornerIsAsDarkAsItsFormula SurfaceLight.BricksBesideThePictureStay
    SurfaceLight.CostsNothingWhereItIsNotAskedFor SurfaceLight.CutsOpen SurfaceLight.DirectionsAreSpreadByTheCosine
    SurfaceLight.EnginesAgree SurfaceLight.ErrorFallsWithDirections SurfaceLight.GlassLetsSomeThrough SurfaceLight.IsItsFormula
    SurfaceLight.RefusalsHelp SurfaceLight.TheFilterHasNoSide SurfaceLight.TakesFromTheAmbientLightAlone SurfaceLight.TakesThePlaceOfTheVoxels
    SurfaceLight.TheFilterKnowsNoVoxels SurfaceLight.TheFilterSmoothsAndKeepsEdges
    SurfaceReference.BothIntegratorsSeeWhatBeginsAtAPointOfTheFunction
    SurfaceReference.SidesAndOrderAreTheSame SurfaceReference.TheVolumeBetweenThemConverges
    Visibility.LevelsChosenBySightAreBetter
)
one_a_feature+=$(printf '|^%s[.]' "${quick_suites[@]}")$(printf '|^%s$' "${quick_tests[@]}")
# What engines have in common with the mirror, on one of the scans' stores.
one_store='^[A-Za-z]+/(Contract|CutPicture|Values|Graded|Native|NativeSurfaces|NativeMixed|Gates|MixedPicture)\..*/torso'

# Sources that only a build with MPI and IceT compiles (.ci/full ranks).
with_icet=(viewer/ranks/*.cpp viewer/cli/modules/ranks_*.cpp)

# Test programs of a file that changed: of its room.
tests_of() { # FILE
    case $1 in
    core/image/*picture* | core/image/image_file* | tests/core/image/*) echo core_test core_image_file_test ;;
    core/* | tests/core/*) echo core_test core_scene_test ;;
    bricking/validate/* | tests/bricking/validate/*) echo bricking_validate_test ;;
    bricking/remote/* | bricking/store/remote* | tests/bricking/remote/*) echo bricking_remote_test ;;
    bricking/store/* | bricking/mask/* | bricking/statistics/* | bricking/import/importer*) echo bricking_store_test ;;
    bricking/cache/*) echo bricking_cache_test ;;
    bricking/import/zarr/* | bricking/import/files/zarr/*) echo import_zarr_test ;;
    tests/fuzz/*) echo fuzz_test ;;
    bricking/levels/*) echo bricking_selection_test ;;
    bricking/labels/* | bricking/import/labels/* | tests/bricking/labels/*) echo bricking_labels_test bricking_label_formats_test ;;
    bricking/analysis/*) echo bricking_lumen_test bricking_body_test ;;
    bricking/import/meshes/* | tests/bricking/meshes/*) echo bricking_meshes_test ;;
    bricking/import/* | tests/bricking/import/*) echo import_test damage_corpus ;;
    datasets/* | tests/datasets/*) echo datasets_phantom_test ;;
    tests/bricking/*) echo bricking_store_test bricking_cache_test ;;
    render/backends/native/* | render/contract/*) echo render_native_test ;;
    render/transport/* | tests/render/transport/*) echo render_transport_test render_paths_test ;;
    render/geometry/* | tests/render/geometry/*) echo render_geometry_test ;;
    render/plan/fusion* | render/picture/several_volumes*) echo render_fusion_test ;;
    render/parts/* | tests/render/parts/*) echo render_unit_test render_parts_test ;;
    render/* | tests/render/*) echo render_unit_test render_engine_test ;;
    viewer/presets/*) echo viewer_presets_test ;;
    viewer/cli/modules/*) echo modules_test ;;
    esac
}
