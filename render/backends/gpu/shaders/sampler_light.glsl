// sampler_light.glsl: light of voxels, as NativeField::received() and StoredLight have it.
// Needs FEATURE_VOXEL_LIGHT, FEATURE_EMISSION, sampler_channels.glsl, march_lights.glsl. Gives receivedLight(p).

#if FEATURE_VOXEL_LIGHT
OF_VOLUME sampler3D uLightTexels;   // a component a channel, at the texels of the atlas
OF_VOLUME sampler3D uLightStanding; // of bricks that stand as one value
OF_VOLUME int uOcclusionChannel;    // -1: none
OF_VOLUME int uLightChannel[kMostLights];
#if FEATURE_EMISSION
OF_VOLUME int uAmbientChannels; // of light from all sides: one for all colours, or the first three
#endif

ReceivedLight receivedLight(vec3 p) {
    precise vec4 light = channelsAt(uLightTexels, uLightStanding, p) * (1.0 / 16384.0);
    ReceivedLight received = allLight();
    if (uOcclusionChannel >= 0) received.fromAllSides = vec3(light[uOcclusionChannel]);
#if FEATURE_EMISSION
    if (uAmbientChannels > 1) received.fromAllSides = light.rgb;
#endif
    TURNS(4);
    for (int i = 0; i < kMostLights; ++i)
        if (uLightChannel[i] >= 0) received.from[i] = light[uLightChannel[i]];
    return received;
}
#elif FEATURE_LIGHTS
ReceivedLight receivedLight(vec3 p) { return allLight(); }
#endif
