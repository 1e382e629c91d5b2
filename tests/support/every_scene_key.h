// tests/support/every_scene_key.h: scenes that have every key.
#pragma once

namespace tessera::test {

/// Every key there is, in two documents because a camera is either fitted or free.
inline constexpr const char* kFittedScene = R"({"tesseraScene":1,
  "volumes":[{"path":"a/x.zarr","unit":"HU","transferFunction":{"scalarOpacityUnitDistance":2.5,
    "scalarOpacity":[[-100,0],[50,0.125],[50,0.5]],"rgbTransferFunction":[[0,0.1,0.2,0.3],[10,1,1,1]],
    "materials":[{"from":-100,"to":0,"ambient":0.3,"diffuse":0.5,"specular":0,"specularPower":1},
      {"from":0,"to":40.5,"ambient":0.125,"diffuse":0.25,"specular":0.5,"specularPower":64,
       "emission":[1,0.5,0.25]}],
    "gradientOpacity":[[0,0],[12.5,0.25],[12.5,0.5],[60,1]],"gradientOpacityUnit":"voxel"}}],
  "camera":{"view":"left","fit":"volume","parallelProjection":true,"mmPerPixel":0.75},
  "shading":{"shade":false,"ambient":0.1,"diffuse":0.7,"specular":0.3,"specularPower":40,
    "gradient":"sobel","model":"blinn-phong","gradientWeight":[2,8.5]},
  "lighting":{"lights":[
      {"kind":"head","intensity":0.5,"colour":[1,1,1],"shadow":false,"softness":0},
      {"kind":"directional","frame":"patient","direction":[0,-1,2],"intensity":1.5,"colour":[1,0.5,0.25],
       "shadow":true,"softness":2.5},
      {"kind":"point","frame":"camera","position":[-100,200,0],"attenuation":[1,0.25,0.125],"intensity":2,
       "colour":[0,0,1],"shadow":false,"softness":0}],
    "occlusion":{"method":"positional","rays":64,"radius":20,"offset":0.5,"bias":0.2,"gamma":0.75,"emission":3},
    "surfaceOcclusion":{"rays":24,"radius":7.5,"filter":false},"finestLevel":2},
  "isosurfaces":[{"value":-300,"rgb":[0.9,0.5,0.25],"opacity":0.5},{"value":200,"rgb":[1,1,1],"opacity":1}],
  "mode":"slice","window":[40.5,400],"valueColour":"transferFunction",
  "slice":{"plane":"oblique","point":[1,2,3.5],"normal":[0,1,1],"thickness":5,"reduction":"maximum"},
  "cuts":{"boxes":[{"low":[1,2,3],"high":[10,20,30.5],"space":"voxels","keep":"outside"}],
    "planes":[{"point":[4,5,6],"normal":[0,0,-1],"keep":"inside"}],
    "scissors":[{"camera":{"position":[1,2,3],"focalPoint":[4,5,6],"viewUp":[0,0,1],"viewAngle":40,
      "parallelProjection":true,"parallelScale":80.5},"aspect":1.5,"outline":[[0,0],[1,0.25],[0.5,1]],"keep":"outside"}]},
  "measurements":[{"kind":"distance","points":[[0,0,0],[1,2,2]]},
    {"kind":"circle","points":[[1,0,0],[0,1,0],[-1,0,0.5]]}],
  "quality":{"stepVoxels":0.25,"integrator":"pre-integrated","fetch":"exact","terminationTransmittance":0,"skipping":false,
    "edgeFunction":"split","sampling":"naive","maxError":2.5,
    "samples":16,"pixelFilter":"gaussian","seed":3},
  "image":{"size":[640,480],"background":"#336699"}})";
inline constexpr const char* kFreeScene =
    R"({"tesseraScene":1,"volumes":[{"path":"/s/x.zarr","unit":"","transferFunction":"lung",
      "series":3,"phase":2,"largest":true,"resampleZ":true,"allowMissing":true}],
  "camera":{"position":[1,2,3.25],"focalPoint":[4,5,6],"viewUp":[0,0.1,1],"viewAngle":110.5,
    "parallelProjection":false,"parallelScale":77.7},"slice":{"plane":"coronal","position":12.5},
  "image":{"background":[0.1,0.2,0.3]}})";

} // namespace tessera::test
