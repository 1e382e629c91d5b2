// common_texels.glsl: single texels of 3D textures, which is up to the driver.
// Needs DRIVER_LLVMPIPE, FEATURE_FUSED. Gives types of uniforms TEXELS_R16, TEXELS_R32F, TEXELS_R32UI, TEXELS_RG32UI,
// as a parameter UINT_TEXELS; texelAt(texels, at), texelsExtent(texels).

#if DRIVER_LLVMPIPE && !FEATURE_FUSED // several volumes have more of them than there are images
// Its texelFetch() finds extent and strides of a level lane by lane, though all lanes ask for level 0. It takes as
// long as a filtered fetch; images have no levels.
#define TEXELS_R16 layout(r16) restrict readonly image3D
#define TEXELS_R32F layout(r32f) restrict readonly image3D
#define TEXELS_R32UI layout(r32ui) restrict readonly uimage3D
#define TEXELS_RG32UI layout(rg32ui) restrict readonly uimage3D
#define UINT_TEXELS restrict readonly uimage3D
#define texelAt(texels, at) imageLoad(texels, at)
#define texelsExtent(texels) imageSize(texels)
#else
#define TEXELS_R16 sampler3D
#define TEXELS_R32F sampler3D
#define TEXELS_R32UI usampler3D
#define TEXELS_RG32UI usampler3D
#define UINT_TEXELS usampler3D
#define texelAt(texels, at) texelFetch(texels, at, 0)
#define texelsExtent(texels) textureSize(texels, 0)
#endif
