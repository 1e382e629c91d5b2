// tests/bench/vtk_renderer.cpp: see vtk_renderer.h.
#include "tests/bench/vtk_renderer.h"

#include "core/base/error.h"
#include "tests/bench/bench_tools.h"

#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <vtkCamera.h>
#include <vtkColorTransferFunction.h>
#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkOpenGLGPUVolumeRayCastMapper.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkShortArray.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnsignedShortArray.h>
#include <vtkVersion.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

namespace tessera::bench {

struct VtkRenderer::State {
    glm::ivec2 size{0};
    double distanceMm = 0; // of the last frame
    vtkNew<vtkImageData> image;
    vtkNew<vtkColorTransferFunction> colour;
    vtkNew<vtkPiecewiseFunction> opacity;
    vtkNew<vtkVolumeProperty> property;
    vtkNew<vtkVolume> volume;
    vtkNew<vtkRenderer> renderer;
    vtkNew<vtkRenderWindow> window;
    vtkSmartPointer<vtkFixedPointVolumeRayCastMapper> cpu;
    vtkSmartPointer<vtkOpenGLGPUVolumeRayCastMapper> gpu;
    vtkNew<vtkUnsignedCharArray> pixels;
};

namespace {

constexpr double kFarOffMm = 1e5; // of a camera in parallel projection
constexpr double kNearMm = 0.05;  // nothing nearer is drawn by a camera in the volume

template <typename Array> vtkSmartPointer<vtkDataArray> wrapped(std::span<const std::byte> voxels) {
    using Value = typename Array::ValueType;
    auto array = vtkSmartPointer<Array>::New();
    // VTK's arrays are not const; it only reads them.
    auto* values = const_cast<Value*>(reinterpret_cast<const Value*>(voxels.data()));
    array->SetArray(values, static_cast<vtkIdType>(voxels.size() / sizeof(Value)), 1);
    return array;
}

/// Voxels without a copy; VTK's points are voxel centres.
void setVoxels(vtkImageData& image, const VolumeInfo& info, std::span<const std::byte> voxels) {
    const glm::dvec3 spacing = info.spacingMm(), origin = firstVoxelCentreMm(info);
    for (int axis = 0; axis < 3; ++axis) // a cosine of a millionth moves a voxel at the far end by none
        if (!(info.patientFromVoxel[axis][axis] > (1 - 1e-12) * spacing[axis]))
            throw InputError(
                "the volume: expected axes along the patient's, which both mappers of VTK can draw");
    image.SetDimensions(info.extentVoxels.x, info.extentVoxels.y, info.extentVoxels.z);
    image.SetSpacing(spacing.x, spacing.y, spacing.z);
    image.SetOrigin(origin.x, origin.y, origin.z);
    vtkSmartPointer<vtkDataArray> scalars;
    switch (info.type) {
    case ValueType::u8:
        scalars = wrapped<vtkUnsignedCharArray>(voxels);
        break;
    case ValueType::i16:
        scalars = wrapped<vtkShortArray>(voxels);
        break;
    case ValueType::u16:
        scalars = wrapped<vtkUnsignedShortArray>(voxels);
        break;
    case ValueType::f32:
        scalars = wrapped<vtkFloatArray>(voxels);
        break;
    }
    image.GetPointData()->SetScalars(scalars);
}

/// Calls add(value, point) for each point, in stored values, ascending. VTK knows one point a value: the left
/// one of a step goes a little to the left, by less than the tables of both mappers tell apart.
/// Both mappers draw from tables that they sample the points into. The CPU's has 2^15 entries at most. The
/// GPU's has as many as the smallest distance between two nodes needs over the values' range, from 1024 to
/// the device's widest texture (vtkOpenGLVolumeLookupTable). A step thus gets the widest; what a table cannot
/// resolve is VTK's error and stays in it.
template <typename Point, typename Add>
void addPoints(const std::vector<Point>& points, const VolumeInfo& info, const Add& add) {
    if (points.empty())
        return;
    const double range = points.back().value - points.front().value;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const bool left = i + 1 < points.size() && points[i + 1].value == points[i].value;
        const double value = left ? points[i].value - 1e-7 * (range > 0 ? range : 1) : points[i].value;
        add((value - info.rescaleIntercept) / info.rescaleSlope, points[i]);
    }
}

void setLight(const Shading& shading, vtkVolumeProperty& property, vtkRenderer& renderer) {
    property.SetShade(shading.on ? 1 : 0);
    property.SetAmbient(shading.ambient);
    property.SetDiffuse(shading.diffuse);
    property.SetSpecular(shading.specular);
    property.SetSpecularPower(4 * std::round(shading.specularPower)); // see vtk_renderer.h
    renderer.TwoSidedLightingOn();
    const vtkNew<vtkLight> light;
    light->SetLightTypeToHeadlight();
    light->SetAmbientColor(1, 1, 1); // black, as it comes: the CPU mapper would know no ambient light
    renderer.AddLight(light);
}

/// After the volume is there.
void setCamera(const Camera& camera, vtkRenderer& renderer) {
    vtkCamera& view = *renderer.GetActiveCamera();
    const bool parallel = camera.projection == Projection::parallel;
    const glm::dvec3 eye =
        parallel ? camera.focalPoint + kFarOffMm * glm::normalize(camera.position - camera.focalPoint)
                 : camera.position;
    view.SetPosition(eye.x, eye.y, eye.z);
    view.SetFocalPoint(camera.focalPoint.x, camera.focalPoint.y, camera.focalPoint.z);
    view.SetViewUp(camera.viewUp.x, camera.viewUp.y, camera.viewUp.z);
    view.SetViewAngle(camera.viewAngle);
    view.SetParallelProjection(parallel ? 1 : 0);
    view.SetParallelScale(camera.parallelScale);
    renderer.ResetCameraClippingRange();
    std::array<double, 6> box{}; // x, y, z: from and to
    renderer.ComputeVisiblePropBounds(box.data());
    const bool inside = box[0] < eye.x && eye.x < box[1] && box[2] < eye.y && eye.y < box[3] &&
                        box[4] < eye.z && eye.z < box[5];
    if (inside) // as it comes, the first hundredth of what is seen is cut off
        view.SetClippingRange(kNearMm, view.GetClippingRange()[1]);
}

} // namespace

std::vector<std::byte> wholeVolume(const StoreReader& store) {
    const VolumeInfo& info = store.info();
    const std::size_t valueBytes = bytesPerValue(info.type);
    std::vector<std::byte> voxels(static_cast<std::size_t>(info.voxelCount()) * valueBytes);
    std::vector<std::byte> chunk(store.chunkBytes());
    const glm::ivec3 grid = chunkGrid(info.extentVoxels, 0);
    for (std::size_t n = 0; n < cellCount(grid); ++n) {
        const auto flat = static_cast<int>(n);
        const glm::ivec3 at(flat % grid.x, flat / grid.x % grid.y, flat / (grid.x * grid.y));
        store.readChunk({0, at.x, at.y, at.z}, chunk);
        const glm::ivec3 low = at * kChunkExtent,
                         size = glm::min(info.extentVoxels - low, glm::ivec3(kChunkExtent));
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y)
                std::memcpy(voxels.data() +
                                linearIndex(low + glm::ivec3(0, y, z), info.extentVoxels) * valueBytes,
                            chunk.data() + linearIndex({0, y, z}, glm::ivec3(kChunkExtent)) * valueBytes,
                            static_cast<std::size_t>(size.x) * valueBytes);
    }
    return voxels;
}

VtkRenderer::VtkRenderer(VtkMapper mapper, const VolumeInfo& info, std::span<const std::byte> voxels,
                         const TransferFunction& function, const Shading& shading, const Camera& camera,
                         const glm::ivec2& size)
    : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.size = size;
    setVoxels(*s.image, info, voxels);
    // The same points, in stored values: VTK too is linear between them, in opacity per unit distance and in
    // RGB.
    addPoints(function.opacityPoints(), info,
              [&](double value, const OpacityPoint& point) { s.opacity->AddPoint(value, point.opacity); });
    addPoints(function.colourPoints(), info, [&](double value, const ColourPoint& point) {
        s.colour->AddRGBPoint(value, point.colour.r, point.colour.g, point.colour.b);
    });
    if (function.colourPoints().empty())
        s.colour->AddRGBPoint(0, 1, 1, 1);
    s.property->SetColor(s.colour);
    s.property->SetScalarOpacity(s.opacity);
    s.property->SetScalarOpacityUnitDistance(function.referenceLengthMm());
    s.property->SetInterpolationTypeToLinear();
    setLight(shading, *s.property, *s.renderer);

    if (mapper == VtkMapper::cpu) {
        s.cpu = vtkSmartPointer<vtkFixedPointVolumeRayCastMapper>::New();
        s.cpu->SetInputData(s.image);
        s.cpu->AutoAdjustSampleDistancesOff();
        s.cpu->LockSampleDistanceToInputSpacingOff();
        s.cpu->SetImageSampleDistance(1);
        s.volume->SetMapper(s.cpu);
    } else {
        s.gpu = vtkSmartPointer<vtkOpenGLGPUVolumeRayCastMapper>::New();
        s.gpu->SetInputData(s.image);
        s.gpu->AutoAdjustSampleDistancesOff();
        s.gpu->LockSampleDistanceToInputSpacingOff();
        s.gpu->UseJitteringOff();
        s.gpu->SetImageSampleDistance(1);
        s.gpu->SetMaxMemoryInBytes(vtkIdType{4} << 30); // nothing is left out or made coarser
        s.gpu->SetMaxMemoryFraction(1);
        s.volume->SetMapper(s.gpu);
    }
    s.volume->SetProperty(s.property);
    s.renderer->AddVolume(s.volume);
    s.renderer->SetBackground(0, 0, 0);
    s.renderer->SetBackgroundAlpha(0);
    setCamera(camera, *s.renderer);
    s.window->SetOffScreenRendering(1);
    s.window->SetMultiSamples(0);
    s.window->SetAlphaBitPlanes(1);
    s.window->SetSize(size.x, size.y);
    s.window->AddRenderer(s.renderer);
}

VtkRenderer::~VtkRenderer() = default;

double VtkRenderer::drawMs(double sampleDistanceMm) {
    State& s = *state_;
    if (s.cpu) {
        s.cpu->SetSampleDistance(static_cast<float>(sampleDistanceMm));
        s.cpu->SetInteractiveSampleDistance(static_cast<float>(sampleDistanceMm));
    } else {
        s.gpu->SetSampleDistance(static_cast<float>(sampleDistanceMm));
    }
    // The CPU mapper corrects a table of opacity for every distance anew. The GPU mapper's is made in a
    // millisecond or two, a frame of it in seconds.
    const bool unprepared = s.cpu ? s.distanceMm != sampleDistanceMm : s.distanceMm == 0;
    if (unprepared) {
        s.distanceMm = sampleDistanceMm;
        s.window->Render();
        s.window->WaitForCompletion();
    }
    const auto start = Clock::now();
    s.window->Render();
    s.window->WaitForCompletion();
    s.window->GetRGBACharPixelData(0, 0, s.size.x - 1, s.size.y - 1, 1, s.pixels);
    return msSince(start);
}

Image VtkRenderer::picture() const {
    const State& s = *state_;
    Image image(s.size);
    for (int y = 0; y < s.size.y; ++y)
        for (int x = 0; x < s.size.x; ++x) {
            const auto at = static_cast<vtkIdType>(s.size.y - 1 - y) * s.size.x + x; // VTK: bottom row first
            for (int c = 0; c < 4; ++c)
                image.at(x, y)[c] = static_cast<float>(s.pixels->GetTypedComponent(at, c)) / 255.0f;
        }
    return image;
}

std::string VtkRenderer::device() const {
    const std::string text = state_->window->ReportCapabilities();
    const auto line = [&](const std::string& key) {
        const std::size_t at = text.find(key);
        if (at == std::string::npos)
            return std::string("?");
        const std::size_t from = text.find_first_not_of(' ', at + key.size());
        return text.substr(from, text.find('\n', from) - from);
    };
    return line("OpenGL renderer string:") + ", OpenGL " + line("OpenGL version string:");
}

std::string VtkRenderer::version() {
    return vtkVersion::GetVTKVersion();
}

} // namespace tessera::bench
