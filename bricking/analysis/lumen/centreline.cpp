// bricking/analysis/lumen/centreline.cpp: see centreline.h.
#include "bricking/analysis/lumen/centreline.h"

#include "bricking/analysis/lumen/centre_path.h"
#include "bricking/analysis/lumen/grow_lumen.h"
#include "bricking/analysis/lumen/lumen_paths.h"
#include "bricking/analysis/lumen/lumen_tree.h"
#include "bricking/analysis/lumen/lumen_values.h"
#include "bricking/analysis/lumen/nearest_voxels.h"
#include "bricking/analysis/lumen/seed_threshold.h"
#include "bricking/analysis/lumen/thin_branches.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <utility>

namespace tessera {
namespace {

constexpr double kNoisesShown = 6; // from the lumen's value to where its wall is drawn
constexpr int kMostJudged = 3;
constexpr std::uint64_t kBlocksOfWidth = 20000;
constexpr double kLeftMm =
    2; // a line this far from what is surely lumen has left it, not just a voxel of noise

std::string placeText(const glm::dvec3& mm) {
    std::array<char, 96> text;
    std::snprintf(text.data(), text.size(), "(%.1f, %.1f, %.1f) mm", mm.x, mm.y, mm.z);
    return text.data();
}

std::string numberText(double number) {
    std::array<char, 48> text;
    std::snprintf(text.data(), text.size(), "%.4g", number);
    return text.data();
}

class Finder {
  public:
    Finder(const ChunkSource& source, const CentrelineRequest& request, MemoryBudget& ram, Progress& progress,
           int threads)
        : info_(source.info()), request_(request), ram_(ram), progress_(progress),
          field_(source, ram, threads), values_(std::in_place, field_.cache(), info_),
          toMm_(info_.patientFromVoxel), toVoxel_(glm::inverse(info_.patientFromVoxel)) {}

    Centrelines run() {
        findLines();
        if (found_.evidence.leaks) // frees the wide lumen, to have room for this one
            found_.lumen.leavesAtMm = leavesAt();
        progress_.end();
        return std::move(found_);
    }

  private:
    void findLines() {
        TESSERA_CHECK(!request_.seeds.empty());
        progress_.stage("examining the seeds");
        for (const CentrelineSeed& seed : request_.seeds)
            requireInVolume(seed);
        findRule();
        requireInLumen();
        progress_.stage("growing the lumen");
        const glm::ivec3 first = *voxelOf(request_.seeds.front());
        std::optional<GrownLumen> grown = growFirst(first);
        if (request_.tree && !request_.threshold && rule_.below && grown)
            judgeWhereWidest(grown, first);
        if (request_.tree && grown && found_.evidence.leaksAt)
            addThinBranchesTo(*grown);
        LumenParts parts(field_.cache(), info_, rule_, ram_, progress_);
        LumenPart& part = grown ? parts.add(std::move(*grown)) : parts.partOf(first);
        if (request_.tree)
            findTree(parts, part, first);
        else {
            walk(parts);
            progress_.stage("centring the line");
            const LumenPart& lumen = parts.whole();
            found_.lumenVoxels = lumen.grown.count;
            centre(lumen.shape);
        }
        found_.lumen = {rule_.threshold, rule_.below ? Lumen::Side::below : Lumen::Side::above, takenOff_,
                        found_.evidence.leaks};
        found_.lumen.unsure = !found_.evidence.clear(rule_.threshold);
        found_.lumen.branchesTo = branchesTo_;
        found_.lumen.branchWall = branchWall_;
        found_.lumen.surface = surface();
    }

    /// The position at which the line leaves the part connected to its beginning at the threshold that does
    /// not leak.
    std::optional<double> leavesAt() {
        const GrownLumen sure =
            growLumen(field_.cache(), info_, *surely_, *voxelOf(request_.seeds.front()), ram_);
        const CentreLine& line = found_.lines.front();
        double inside = 0; // the last place within it
        for (std::size_t i = 0; i < line.points.size(); ++i) {
            const double along = line.spacingMm * static_cast<double>(i);
            if (sure.voxels.containsPlace(glm::dvec3(toVoxel_ * glm::dvec4(line.points[i], 1))))
                inside = along;
            else if (along - inside >= kLeftMm)
                return inside;
        }
        return std::nullopt;
    }

    glm::dvec3 placeOf(const CentrelineSeed& seed) const { return placeOf(seed.mm); }
    glm::dvec3 placeOf(const glm::dvec3& mm) const { return glm::dvec3(toVoxel_ * glm::dvec4(mm, 1)); }
    glm::dvec3 mmOf(const glm::ivec3& voxel) const {
        return glm::dvec3(toMm_ * glm::dvec4(glm::dvec3(voxel) + 0.5, 1));
    }

    void requireInVolume(const CentrelineSeed& seed) const {
        const glm::dvec3 place = placeOf(seed), n(info_.extentVoxels);
        if (glm::all(glm::greaterThanEqual(place, glm::dvec3(0))) && glm::all(glm::lessThan(place, n)))
            return;
        glm::dvec3 low(1e300), high(-1e300);
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 at(toMm_ *
                                glm::dvec4(glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2) * n, 1));
            low = glm::min(low, at);
            high = glm::max(high, at);
        }
        throw badFile(seed.name, "a point in the volume, from " + placeText(low) + " to " + placeText(high),
                      placeText(seed.mm));
    }

    std::string ruleText() const {
        return std::string(rule_.below ? "below " : "above ") + numberText(rule_.threshold) +
               (info_.unit.empty() ? "" : " " + info_.unit);
    }

    SeedNeighbourhood near(const CentrelineSeed& seed) {
        if (judgedAt_)
            return neighbourhoodOf(*values_, glm::dvec3(*judgedAt_) + 0.5, seed.name);
        return request_.threshold ? neighbourhoodOf(*values_, placeOf(seed), *request_.threshold)
                                  : neighbourhoodOf(*values_, placeOf(seed), seed.name);
    }

    /// If values are noisy around a seed, all further steps use denoised values.
    void takeNoiseOff() {
        bool noisy = false;
        takenOff_ = 0;
        for (const CentrelineSeed& seed : request_.seeds) {
            if (seed.mayBridge)
                continue;
            const SeedNeighbourhood around = near(seed);
            if (&seed == &request_.seeds.front())
                found_.evidence.noise = around.noise;
            noisy = noisy || around.noisy();
            takenOff_ = std::max(takenOff_, around.noise);
        }
        if (!noisy) {
            takenOff_ = 0;
            return;
        }
        values_.reset(); // it holds chunks
        field_.quieten(takenOff_);
        values_.emplace(field_.cache(), info_);
    }

    void findRule() {
        takeNoiseOff();
        const CentrelineSeed* first = nullptr;
        for (const CentrelineSeed& seed : request_.seeds) {
            if (seed.mayBridge)
                continue;
            const SeedNeighbourhood here = near(seed);
            const bool within = rule_.below ? here.lumen < rule_.threshold : here.lumen > rule_.threshold;
            if (first && here.rule.below != rule_.below && within)
                continue; // beside the wall, or in a fold: what is around it says nothing of the threshold
            if (first && here.rule.below != rule_.below)
                throw badFile(seed.name, "a point in the lumen of " + first->name + ", " + ruleText(),
                              numberText(here.lumen) + " at " + placeText(seed.mm));
            // of several thresholds the strictest
            const double brightest = std::max(here.rule.brightest, rule_.brightest);
            const bool stricter = !first || (rule_.below ? here.rule.threshold < rule_.threshold
                                                         : here.rule.threshold > rule_.threshold);
            if (stricter)
                rule_ = here.rule;
            rule_.brightest = first ? brightest : here.rule.brightest;
            if (!first) {
                first = &seed;
                around_ = here;
            }
        }
        TESSERA_CHECK(first);
        found_.evidence.lumen = around_.lumen;
        found_.evidence.wall = around_.wall;
        found_.evidence.noiseLeft = around_.noise;
        found_.evidence.given = request_.threshold.has_value();
    }

    void requireInLumen() {
        for (const CentrelineSeed& seed : request_.seeds)
            if (!seed.mayBridge && !voxelOf(seed))
                throw badFile(seed.name, "a point in the lumen, " + ruleText(),
                              numberText(values_->at(placeOf(seed))) + " at " + placeText(seed.mm));
    }

    /// The part connected to the first seed, with a threshold that does not leak. None if such a threshold
    /// separates the seeds, or if leaks are allowed.
    std::optional<GrownLumen> growFirst(const glm::ivec3& seed) {
        // contrast continues into veins, heart and bone: this does not prevent a path to its end
        if (request_.mayLeak || (!rule_.below && !request_.tree))
            return std::nullopt;
        SeedNeighbourhood around = around_;
        around.rule = rule_;
        GuardedLumen guarded = growWithoutLeaks(field_.cache(), info_, around, seed, request_.tree, ram_);
        if (!guarded.leaked)
            return std::move(guarded.grown);
        found_.evidence.leaksAt = rule_.threshold;
        surely_ = guarded.rule;
        const LumenRule before = std::exchange(rule_, guarded.rule);
        for (const CentrelineSeed& other : request_.seeds)
            if (const auto voxel = voxelOf(other);
                !other.mayBridge && (!voxel || !guarded.grown.voxels.contains(*voxel))) {
                rule_ = before;
                found_.evidence.leaks = true;
                return std::nullopt;
            }
        return std::move(guarded.grown);
    }

    /// Every seed of a lumen gives the same tree if values are measured at one point: where the lumen is
    /// widest.
    void judgeWhereWidest(std::optional<GrownLumen>& grown, const glm::ivec3& first) {
        for (int turn = 0; turn < kMostJudged; ++turn) {
            const glm::ivec3 widest = widestOf(*grown);
            if (judgedAt_ == widest)
                return;
            judgedAt_ = widest;
            grown.reset();
            try {
                startAgain();
                grown = growFirst(widest);
            } catch (const BadFile&) { // no wall is near
                grown.reset();
            }
            if (grown && grown->voxels.contains(first))
                continue;
            judgedAt_.reset(); // the seed alone tells
            grown.reset();
            startAgain();
            grown = growFirst(first);
            return;
        }
    }
    void startAgain() {
        found_.evidence = {};
        surely_.reset();
        values_.reset(); // it holds chunks
        field_.unquieten();
        values_.emplace(field_.cache(), info_);
        findRule();
    }
    glm::ivec3 widestOf(const GrownLumen& grown) {
        const LumenGraph graph(grown.voxels, info_.spacingMm(), kBlocksOfWidth, ram_);
        LumenNode widest = 0;
        for (LumenNode node = 1; node < graph.count(); ++node)
            if (graph.wallMm(node) > graph.wallMm(widest))
                widest = node;
        return graph.someVoxel(widest);
    }
    void addThinBranchesTo(GrownLumen& grown) {
        const double wall = branchWall(around_, rule_);
        branchesTo_ = addThinBranches(*values_, grown, rule_, wall, *found_.evidence.leaksAt, ram_).to;
        if (branchesTo_)
            branchWall_ = wall;
    }

    /// An isovalue beyond a tightened threshold, by the volume's noise: nearer to the lumen's value, noise
    /// would appear as debris in the lumen, or close thin branches. At most the half-way value.
    std::optional<double> surface() const {
        const LumenEvidence& evidence = found_.evidence;
        if (!evidence.leaksAt || evidence.leaks || !(takenOff_ > 0 || branchesTo_))
            return std::nullopt;
        const double tight = std::abs(branchesTo_.value_or(rule_.threshold) - evidence.lumen),
                     wide = std::abs(*evidence.leaksAt - evidence.lumen);
        return evidence.lumen +
               (rule_.below ? 1 : -1) * std::clamp(kNoisesShown * takenOff_, tight, std::max(tight, wide));
    }

    /// A tightened threshold is far from half way: radii extend to the half-way value.
    void toWalls(const LumenShape& shape) {
        if (!found_.evidence.leaksAt || found_.evidence.leaks)
            return;
        for (CentreLine& line : found_.lines)
            for (std::size_t i = 0; i < line.points.size(); ++i)
                if (line.radiusMm[i] > 0)
                    line.radiusMm[i] += shape.edgeBeyondMm(
                        line.points[i], line.radiusMm[i], *values_,
                        rule_.orTaking(values_->at(placeOf(line.points[i]))), found_.evidence.lumen);
    }

    void findTree(LumenParts& parts, LumenPart& part, const glm::ivec3& seed) {
        progress_.stage("searching the branches");
        const LumenGraph& graph = parts.graphOf(part, kBlocksOfTree);
        const std::vector<LumenLimb> limbs = lumenLimbs(graph, graph.nodeAt(seed), ram_, progress_.shares());
        progress_.stage("centring the branches");
        LumenBranches branches = branchLines(graph, limbs, part.shape, *values_, rule_, request_.spacingMm,
                                             request_.mostGenerations, progress_.shares());
        found_.lines = std::move(branches.lines);
        found_.generations = std::move(branches.generations);
        toWalls(part.shape);
        found_.leastTurnMm = branches.leastTurnMm;
        found_.lumenVoxels = part.grown.count;
        found_.blockVoxels = graph.blockExtent();
    }

    /// The lumen voxel at a seed, or the nearest neighbour; none: the seed is not in the lumen.
    std::optional<glm::ivec3> voxelOf(const CentrelineSeed& seed) {
        const glm::ivec3 own(glm::floor(placeOf(seed)));
        std::optional<glm::ivec3> best;
        double least = 1e300;
        for (int z = -1; z <= 1; ++z)
            for (int y = -1; y <= 1; ++y)
                for (int x = -1; x <= 1; ++x) {
                    const glm::ivec3 v = own + glm::ivec3(x, y, z);
                    if (v != glm::clamp(v, glm::ivec3(0), info_.extentVoxels - 1) ||
                        !rule_.takes(values_->voxel(v)))
                        continue;
                    if (const double away = glm::length(mmOf(v) - seed.mm); away < least) {
                        least = away;
                        best = v;
                    }
                }
        return best;
    }

    // ---- the chain from seed to seed

    void addWay(LumenParts& parts, LumenPart& part, const glm::ivec3& from,
                const std::optional<glm::ivec3>& to) {
        ChainPiece piece;
        for (const glm::ivec3& voxel : parts.way(part, from, to))
            piece.mm.push_back(mmOf(voxel));
        found_.blockVoxels = std::max(found_.blockVoxels, parts.graphOf(part).blockExtent());
        pieces_.push_back(std::move(piece));
    }
    void addBridge(const glm::dvec3& from, const glm::dvec3& to) {
        ChainPiece piece;
        piece.bridge = true;
        const double step = std::min({info_.spacingMm().x, info_.spacingMm().y, info_.spacingMm().z});
        const int count = std::max(2, static_cast<int>(glm::length(to - from) / step));
        for (int i = 1; i < count; ++i)
            piece.mm.push_back(from + (to - from) * (static_cast<double>(i) / count));
        pieces_.push_back(std::move(piece));
        found_.bridges.push_back({from, to});
    }

    void walk(LumenParts& parts) {
        const auto& seeds = request_.seeds;
        glm::ivec3 at = *voxelOf(seeds.front());
        LumenPart* part = &parts.partOf(at); // null: in a gap, at the seed
        if (seeds.size() == 1)
            addWay(parts, *part, at, {});
        for (std::size_t i = 1; i < seeds.size(); ++i) {
            const CentrelineSeed &before = seeds[i - 1], &seed = seeds[i];
            const std::optional<glm::ivec3> voxel = voxelOf(seed);
            LumenPart* next = voxel ? &parts.partOf(*voxel) : nullptr;
            if (part && part == next) {
                addWay(parts, *part, at, *voxel);
                at = *voxel;
                continue;
            }
            if (part && next && !before.mayBridge && !seed.mayBridge)
                refuseGap(*part, *next, before, seed);
            glm::dvec3 from = part ? mmOf(at) : before.mm, to = voxel ? mmOf(*voxel) : seed.mm;
            if (part && seed.mayBridge) { // from the part's nearest point to the seed
                const glm::ivec3 leaves = nearestVoxel(part->shape, to).voxel;
                addWay(parts, *part, at, leaves);
                from = mmOf(leaves);
            }
            glm::ivec3 enters = voxel.value_or(glm::ivec3(0));
            if (next && !seed.mayBridge) { // to the next part's nearest point to the seed before
                enters = nearestVoxel(next->shape, from).voxel;
                to = mmOf(enters);
            }
            addBridge(from, to);
            if (next && enters != *voxel)
                addWay(parts, *next, enters, *voxel);
            part = next;
            if (voxel)
                at = *voxel;
        }
    }

    [[noreturn]] void refuseGap(const LumenPart& a, const LumenPart& b, const CentrelineSeed& from,
                                const CentrelineSeed& to) {
        progress_.stage("measuring the gap");
        const Gap gap = nearestGap(a.shape, b.shape, ram_);
        throw badFile(to.name, "a point that the lumen of " + from.name + " (" + ruleText() + ") reaches",
                      "a gap: the two parts come nearest at " + placeText(gap.fromMm) + " and " +
                          placeText(gap.toMm) + ", " + numberText(gap.mm) +
                          " mm apart; a seed at the gap bridges it, another threshold may close it");
    }

    void centre(const LumenShape& shape) {
        std::size_t points = 0;
        for (const ChainPiece& piece : pieces_)
            points += piece.mm.size();
        const Charge charge = ram_.charge(points * 8 * sizeof(glm::dvec3), "the line");
        CentringRules rules;
        rules.spacingMm = request_.spacingMm;
        const CentredLine line = centrePath(shape, pieces_, *values_, rule_, rules);
        found_.leastTurnMm = line.leastTurnMm;
        CentreLine out;
        out.points = line.mm;
        out.radiusMm = line.radiusMm;
        out.spacingMm = line.spacingMm;
        found_.lines.push_back(std::move(out));
        found_.generations.push_back(0);
        toWalls(shape);
    }

    const VolumeInfo& info_;
    const CentrelineRequest& request_;
    MemoryBudget& ram_;
    Progress& progress_;
    LumenField field_;
    std::optional<LumenValues> values_;
    double takenOff_ = 0; // standard deviation of the noise; 0: none
    const glm::dmat4 toMm_, toVoxel_;
    LumenRule rule_;
    std::optional<LumenRule> surely_; // if rule_ leaks: a rule that does not
    SeedNeighbourhood around_;        // of the first seed
    std::optional<double> branchesTo_, branchWall_;
    std::optional<glm::ivec3>
        judgedAt_; // voxel whose surroundings define the lumen's values; none: the seeds
    std::vector<ChainPiece> pieces_;
    Centrelines found_;
};

} // namespace

Centrelines findCentrelines(const ChunkSource& source, const CentrelineRequest& request, MemoryBudget& ram,
                            Progress& progress, int threads) {
    return Finder(source, request, ram, progress, threads).run();
}

} // namespace tessera
