// core/scene/transfer_function.h: transfer functions: editable points, the exact function between them
// (docs/sampling.md, "Transfer function"), and the table of floats that engines read. Gradient opacity: a
// factor on a transfer function's extinction, by the length of the field's gradient (docs/sampling.md,
// "Gradient opacity").
#pragma once

#include "core/scene/transport.h"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {

struct GradientPoint {
    double length = 0; // of the gradient, physical units per mm, or per voxel
    double factor = 1; // [0,1]
    bool operator==(const GradientPoint&) const = default;
};

/// Linear between points, constant beyond the outermost. Two points at one length are a step; the length
/// itself takes the right one.
class GradientOpacity {
  public:
    /// The unit of lengths: per millimetre, or per mean of a volume's three spacings, as in VTK
    /// (vtkVolumeShaderComposer.h, computeGradient()).
    enum class Per { mm, voxel };
    static constexpr std::size_t kMostPoints = 16;

    /// 1 everywhere.
    GradientOpacity() = default;
    /// Points in any order; sorted stably. Factors are clamped to [0,1]. If all factors are 1, there are no
    /// points. Throws InputError naming where for lengths and factors that are not finite, lengths below 0,
    /// and more than kMostPoints.
    static GradientOpacity fromPoints(std::vector<GradientPoint> points, Per per = Per::mm,
                                      const std::string& where = "gradient opacity");

    bool isOne() const { return points_.empty(); }
    const std::vector<GradientPoint>& points() const { return points_; }
    Per per() const { return per_; }
    /// @param length  in the points' unit
    double factor(double length) const;
    /// The same of lengths per mm.
    /// @param spacingMm  of the volume, the mean over its axes
    GradientOpacity perMm(double spacingMm) const;
    bool operator==(const GradientOpacity&) const = default;

  private:
    std::vector<GradientPoint> points_; // by length
    Per per_ = Per::mm;
};

struct OpacityPoint {
    double value = 0;   // physical units (HU)
    double opacity = 0; // [0,1] per referenceLengthMm; or extinction per mm, see fromExtinction()
    bool operator==(const OpacityPoint&) const = default;
};
struct ColourPoint {
    double value = 0;       // physical units (HU)
    glm::dvec3 colour{1.0}; // linear light, Rec. 709 primaries, [0,1], not premultiplied
    bool operator==(const ColourPoint&) const = default;
};

/// What a surface or a tissue makes of light, as Shading has it.
struct MaterialResponse {
    double ambient = 0.2, diffuse = 0.8, specular = 0.25;
    int specularPower = 20;
    bool operator==(const MaterialResponse&) const = default;
};

/// Material response of a range of values, in place of the scene's shading.
struct Material {
    double from = 0, to = 0; // physical units, `to` excluded
    double ambient = 0.2, diffuse = 0.8, specular = 0.25;
    int specularPower = 20;
    glm::dvec3 emission{0}; // emitted light, linear, [0,1]
    bool operator==(const Material&) const = default;
};

/// Opacity and colour as functions of the physical value, piecewise linear between points, constant beyond
/// the outermost ones. Two points at one value are a step; the value itself takes the right one. Three or
/// more at one value: the first is the left limit, the last the right one.
class TransferFunction {
  public:
    TransferFunction() = default;
    /// Points in any order; sorted stably. Opacities and colours are clamped to [0,1].
    /// No opacity points: transparent everywhere; no colour points: white.
    /// Throws InputError naming where for values that no voxel can hold (core/base/magnitude.h), opacities or
    /// colours that are not finite, and for a reference length that is not positive and finite.
    static TransferFunction fromOpacity(std::vector<OpacityPoint> opacity, std::vector<ColourPoint> colour,
                                        double referenceLengthMm,
                                        const std::string& where = "transfer function");
    /// The same with extinction (1/mm, >= 0) at the points, linear between them: for tests with closed forms.
    static TransferFunction fromExtinction(std::vector<OpacityPoint> extinction,
                                           std::vector<ColourPoint> colour,
                                           const std::string& where = "transfer function");

    /// 1/mm: -log1p(-min(opacity, 1-2^-24)) / referenceLengthMm. It does not depend on a step.
    double extinction(double value) const;
    /// Opacity or extinction, whichever the points have, at a value.
    double extinctionOf(double opacity) const;
    glm::dvec3 colour(double value) const;
    /// Values, ascending, where the function is not smooth: every point.
    const std::vector<double>& kinks() const { return kinks_; }
    /// Times all extinctions, [0,1]; points stay as they are.
    void setShare(double share) { share_ = share; }
    const std::vector<OpacityPoint>& opacityPoints() const { return opacity_; }
    const std::vector<ColourPoint>& colourPoints() const { return colour_; }
    double referenceLengthMm() const { return referenceLengthMm_; }
    static constexpr std::size_t kMaxMaterials = 8;
    /// Ascending. Throws InputError naming where for ranges that are empty or share values, values that no
    /// voxel can hold, and for more than kMaxMaterials.
    void setMaterials(std::vector<Material> materials, const std::string& where = "transfer function");
    const std::vector<Material>& materials() const { return materials_; }
    static constexpr std::size_t kMaxTissues = 16;
    /// For light along paths alone. As setMaterials().
    void setTissues(std::vector<Tissue> tissues, const std::string& where = "transfer function");
    const std::vector<Tissue>& tissues() const { return tissues_; }
    /// True if a material emits light.
    bool emits() const;
    /// Factor on the extinction by the gradient's length; extinction() is without it.
    void setGradientOpacity(GradientOpacity factor) { gradientOpacity_ = std::move(factor); }
    const GradientOpacity& gradientOpacity() const { return gradientOpacity_; }
    bool operator==(const TransferFunction&) const = default;

  private:
    std::vector<OpacityPoint> opacity_;
    std::vector<ColourPoint> colour_;
    std::vector<double> kinks_;
    std::vector<Material> materials_;
    std::vector<Tissue> tissues_;
    GradientOpacity gradientOpacity_;
    double referenceLengthMm_ = 1, share_ = 1;
    bool pointsAreExtinction_ = false;
};

/// A transfer function by the name of a preset, or spelled out.
using TransferChoice = std::variant<std::string, TransferFunction>;

/// An isosurface, as far as it matters for visibility.
struct SurfaceValue {
    double value = 0; // physical units
    glm::vec3 colour{1};
    double opacity = 1;
};

/// The function as ray casters read it: equidistant samples, linear between them, in float.
struct TransferTable {
    float firstValue = 0;           // value of entries.front(); values below read as it
    float entriesPerValue = 0;      // (entries.size()-1) / (last value - first value)
    std::vector<glm::vec4> entries; // rgb: colour; a: extinction, 1/mm. At least 2, at most kMaxEntries.
    /// Largest |extinction of table - of points| / largest extinction, over a fine sweep without the
    /// neighbourhood (one table bin) of steps, which no table of finite size can follow.
    double relativeError = 0;
    std::vector<SurfaceValue> surfaces; // ascending
    GradientOpacity gradientOpacity;    // on the extinctions; at most 1, so that it makes nothing visible
    /// Number of visible entries up to and including i, for emptyOver(). An entry is visible if its
    /// extinction is not 0, or an isosurface's value is at it or beside it.
    std::vector<int> nonZeroUpTo;

    static constexpr int kMaxEntries = 65536; // 1 MiB: one entry per HU over the whole 16-bit range
    /// True if the table's extinction is exactly 0 on all of [lowest, highest] (physical units), without an
    /// isosurface's value. It is conservative by one entry on both sides, so that float rounding of an index
    /// cannot matter.
    bool emptyOver(double lowest, double highest) const;
    bool shows(std::size_t entry) const {
        return nonZeroUpTo[entry] != (entry == 0 ? 0 : nonZeroUpTo[entry - 1]);
    }
    /// True if no entry has an extinction.
    bool isTransparent() const;
    /// A table of the isosurfaces alone: entries beside their values have an extinction of 1, all others
    /// none.
    TransferTable ofSurfaces() const;
    /// For error prediction of levels: models each isosurface as a step in opacity at its value. Above the
    /// step a nearly opaque surface is as good as opaque within a few voxels; any other is thin and hides
    /// little.
    TransferTable withSurfacesAsSteps(double voxelMm) const;
};

/// The size follows the sharpest feature: a power of two with at least 8 entries between the two closest
/// points; with isosurfaces, whose values the table covers, at least 4096.
TransferTable makeTable(const TransferFunction& function, std::vector<SurfaceValue> surfaces = {});

} // namespace tessera
