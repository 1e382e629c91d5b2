// viewer/window/label_panel.cpp: see label_panel.h.
#include "viewer/window/label_panel.h"

#include "core/base/shown_text.h"
#include "core/image/colour.h"
#include "viewer/window/boxes.h"

#include <algorithm>
#include <cctype>
#include <imgui.h>
#include <map>
#include <utility>

namespace tessera {
namespace {

constexpr float kListHeight = 260, kSwatch = 14, kIndent = 14;
constexpr const char* kAlone = "only";
const ImVec4 kFaintName(0.5f, 0.5f, 0.5f, 1.0f);

std::string inLower(std::string text) {
    for (char& c : text)
        c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

/// An edit of one step.
template <typename Edit> void editLabels(WindowState& desk, const Edit& edit) {
    desk.trying([&] {
        const Labels labels = edit(*desk.volume()->labels, desk.labels());
        desk.beginEdit();
        desk.setLabels(labels, false);
    });
}

} // namespace

void showAlone(WindowState& desk, LabelNumbers numbers) {
    editLabels(desk, [&](const LabelList& list, const Labels& labels) {
        const Labels alone = withAlone(list, labels, numbers);
        return alone == labels ? withAllShown(labels) : alone;
    });
}

void showAlone(WindowState& desk, const PickedPlace& picked) {
    std::vector<std::size_t> numbers;
    for (const std::uint32_t value : picked.labels)
        if (const auto number = numberOf(*desk.volume()->labels, value))
            numbers.push_back(*number);
    if (!picked.hit)
        desk.tell("nothing is visible there");
    else if (numbers.empty())
        desk.tell("no label is there");
    else
        showAlone(desk, numbers);
}

std::string labelNames(const VolumeSeen& volume, const PickedPlace& picked) {
    std::string names;
    for (const std::uint32_t value : picked.labels)
        if (const auto number = volume.labels ? numberOf(*volume.labels, value) : std::nullopt)
            names += (names.empty() ? "" : ", ") + printable((*volume.labels)[*number].name);
    return names;
}

void LabelPanel::forget() {
    if (of_)
        *this = {};
}

/// Groups where there are any, then labels without one, and behind them those without a voxel.
void LabelPanel::take(const WindowState& desk) {
    if (of_ != desk.volume()->labels) {
        forget();
        of_ = desk.volume()->labels;
        Group others, absent;
        absent.absent = true;
        std::map<std::string, std::size_t> known;
        for (std::size_t n = 0; n < of_->size(); ++n) {
            const ListedLabel& label = (*of_)[n];
            if (!label.hasVoxels) {
                absent.numbers.push_back(n);
            } else if (label.group.empty()) {
                others.numbers.push_back(n);
            } else {
                const auto [at, isNew] = known.emplace(label.group, groups_.size());
                if (isNew)
                    groups_.push_back({label.group, {}});
                groups_[at->second].numbers.push_back(n);
            }
        }
        for (Group* const last : {&others, &absent})
            if (!last->numbers.empty())
                groups_.push_back(std::move(*last));
        another_ = true;
    } else if (desk.labels() == labels_) {
        return;
    }
    labels_ = desk.labels();
    states_ = labelStates(*of_, labels_);
}

void LabelPanel::findRows() {
    if (!std::exchange(another_, false))
        return;
    rows_.clear();
    const std::string searched = inLower(search_);
    const auto isMeant = [&](std::size_t number) {
        const ListedLabel& label = (*of_)[number];
        return searched.empty() || inLower(label.name).find(searched) != std::string::npos ||
               inLower(label.group).find(searched) != std::string::npos ||
               std::to_string(label.value) == searched;
    };
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        const Group& group = groups_[g];
        const std::size_t before = rows_.size();
        if (groups_.size() > 1 || !group.name.empty() || group.absent)
            rows_.push_back({g, nullptr});
        const std::size_t first = rows_.size();
        if (group.open || !searched.empty())
            for (const std::size_t& number : group.numbers)
                if (isMeant(number))
                    rows_.push_back({g, &number});
        if (rows_.size() == first && !searched.empty())
            rows_.resize(before); // nothing of the group is meant
    }
}

void LabelPanel::draw(WindowState& desk) {
    take(desk);
    either(desk);
    all(desk);
    findRows();
    list(desk);
    look(desk);
}

/// A file that was taken as labels, and may be a volume.
void LabelPanel::either(WindowState& desk) {
    const std::filesystem::path file = desk.volume()->eitherFile;
    if (file.empty() || file != desk.labels().path)
        return;
    if (ImGui::Button("open as a volume", {-1, 0})) {
        VolumePick pick;
        pick.asVolume = true;
        desk.open(file, pick);
    }
}

/// What holds for all of them.
void LabelPanel::all(WindowState& desk) {
    if (desk.scene().mode != Mode::slice && reductionOf(desk.scene()) != Reduction::composite)
        wrapped("mode %s draws no labels", nameOf(desk.scene().mode).c_str());
    ImGui::SetNextItemWidth(-78);
    if (ImGui::InputTextWithHint("##search", "search", search_, sizeof search_))
        another_ = true;
    ImGui::SameLine();
    if (ImGui::Button("show all", {-1, 0}))
        editLabels(desk, [](const LabelList&, const Labels& labels) { return withAllShown(labels); });
    if (const auto taken = nameBox("look", nameOf(desk.labels().look), namesOf<LabelLook>().all()))
        editLabels(desk, [&](const LabelList&, const Labels& labels) {
            return withLook(labels, parseName<LabelLook>(*taken, "look"));
        });
    Labels labels = desk.labels();
    const bool solid = labels.look == LabelLook::solid;
    auto opacity = static_cast<float>(labels.opacity.value_or(1));
    const bool moved = ImGui::SliderFloat("opacity", &opacity, 0, 1, solid ? "%.3f per mm" : "%.2f",
                                          solid ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None);
    if (ImGui::IsItemActivated())
        desk.beginEdit();
    if (moved) {
        labels.opacity = std::clamp(static_cast<double>(opacity), 0.0, 1.0);
        desk.setLabels(labels, true);
    }
    inSlices(desk);
    bool unlabelled = showsUnlabelled(desk.labels());
    if (ImGui::Checkbox("tissue without a label", &unlabelled))
        editLabels(desk,
                   [&](const LabelList&, const Labels& now) { return withUnlabelled(now, unlabelled); });
}

/// How they lie over the values of planes.
void LabelPanel::inSlices(WindowState& desk) {
    constexpr float kWidest = 5; // pixels; more can be typed
    Labels labels = desk.labels();
    auto fill = static_cast<float>(labels.fill.value_or(labels.opacity.value_or(Labels::kFill)));
    bool moved = ImGui::SliderFloat("in slices", &fill, 0, 1, "%.2f");
    if (ImGui::IsItemActivated())
        desk.beginEdit();
    if (moved)
        labels.fill = std::clamp(static_cast<double>(fill), 0.0, 1.0);
    auto outline = static_cast<float>(labels.outline);
    const bool widened = ImGui::SliderFloat("outline", &outline, 0, kWidest, "%.1f pixels");
    if (ImGui::IsItemActivated())
        desk.beginEdit();
    if (widened)
        labels.outline = std::clamp(static_cast<double>(outline), 0.0, Labels::kWidestOutline);
    moved = moved || widened;
    if (moved)
        desk.setLabels(labels, true);
}

void LabelPanel::list(WindowState& desk) {
    const float row = ImGui::GetTextLineHeightWithSpacing();
    const float height =
        std::min(kListHeight, row * static_cast<float>(rows_.size()) + 2 * ImGui::GetStyle().WindowPadding.y);
    ImGui::BeginChild("labels", {0, std::max(height, 2 * row)}, true);
    ImGuiListClipper clipper; // of hundreds of rows only those in sight are drawn
    clipper.Begin(static_cast<int>(rows_.size()), row);
    while (clipper.Step())
        for (int n = clipper.DisplayStart; n < clipper.DisplayEnd; ++n) {
            const Row shown = rows_[static_cast<std::size_t>(n)];
            if (shown.number) {
                ImGui::PushID(static_cast<int>((*of_)[*shown.number].value));
                label(desk, *shown.number);
            } else {
                ImGui::PushID(&groups_[shown.group]);
                header(desk, groups_[shown.group]);
            }
            ImGui::PopID();
        }
    clipper.End();
    if (rows_.empty())
        ImGui::TextDisabled("none");
    ImGui::EndChild();
}

void LabelPanel::header(WindowState& desk, Group& group) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float height = ImGui::GetTextLineHeight(), y = at.y + height / 2;
    if (ImGui::InvisibleButton("open", {kIndent, height}))
        group.open = !group.open, another_ = true;
    ImDrawList& drawn = *ImGui::GetWindowDrawList();
    const ImU32 ink = ImGui::GetColorU32(ImGuiCol_Text);
    if (group.open)
        drawn.AddTriangleFilled({at.x, y - 3}, {at.x + 8, y - 3}, {at.x + 4, y + 4}, ink);
    else
        drawn.AddTriangleFilled({at.x + 2, y - 5}, {at.x + 8, y}, {at.x + 2, y + 4}, ink);
    ImGui::SameLine(0, 0);
    const std::string words = (group.absent         ? std::string("not in the scan")
                               : group.name.empty() ? std::string("without a group")
                                                    : printable(group.name)) +
                              " (" + std::to_string(group.numbers.size()) + ")";
    if (!group.absent) {
        eye(desk, group.numbers);
        swatch(group.numbers, words);
    }
    name(words, group.absent, !group.absent, "");
    if (!group.absent)
        alone(desk, group.numbers);
}

void LabelPanel::label(WindowState& desk, std::size_t number) {
    const ListedLabel& listed = (*of_)[number];
    const std::size_t numbers[] = {number};
    const std::string words = printable(listed.name);
    if (groups_.size() > 1) {
        ImGui::Dummy({kIndent, ImGui::GetTextLineHeight()});
        ImGui::SameLine(0, 0);
    }
    if (!listed.hasVoxels) {
        name(words, true, false, ", value " + std::to_string(listed.value) + ", without a voxel in the scan");
        return;
    }
    eye(desk, numbers);
    swatch(numbers, words);
    name(words, !states_[number].shows, true, ", value " + std::to_string(listed.value));
    alone(desk, numbers);
}

void LabelPanel::eye(WindowState& desk, LabelNumbers numbers) {
    const auto shown = static_cast<std::size_t>(std::count_if(
        numbers.begin(), numbers.end(), [this](std::size_t number) { return states_[number].shows; }));
    const EyeState state = shown == numbers.size() ? EyeState::open
                           : shown > 0             ? EyeState::some
                                                   : EyeState::shut;
    if (eyeButton(state))
        editLabels(desk, [&](const LabelList& list, const Labels& labels) {
            return withShown(list, labels, numbers, state == EyeState::shut);
        });
}

/// Opens the popup with colour and opacity.
void LabelPanel::swatch(LabelNumbers numbers, const std::string& words) {
    const glm::vec3 rgb = screenRgb(states_[numbers.front()].colour);
    if (ImGui::ColorButton("colour", {rgb.r, rgb.g, rgb.b, 1},
                           ImGuiColorEditFlags_NoTooltip | ImGuiColorEditFlags_NoDragDrop,
                           {kSwatch, ImGui::GetTextLineHeight()})) {
        look_.assign(numbers.begin(), numbers.end());
        lookName_ = words;
        opensLook_ = true;
    }
    ImGui::SameLine(0, 6);
}

/// A name, cut off before the button at the right.
/// @param more  for the tooltip
void LabelPanel::name(const std::string& words, bool faint, bool hasButton, const std::string& more) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float wide = ImGui::GetContentRegionAvail().x -
                       (hasButton ? ImGui::CalcTextSize(kAlone).x + 3 * ImGui::GetStyle().FramePadding.x : 0);
    ImGui::PushClipRect(at, {at.x + wide, at.y + ImGui::GetTextLineHeightWithSpacing()}, true);
    ImGui::GetWindowDrawList()->AddText(
        at, faint ? ImGui::GetColorU32(kFaintName) : ImGui::GetColorU32(ImGuiCol_Text), words.c_str());
    ImGui::PopClipRect();
    ImGui::Dummy({std::max(1.0f, wide), ImGui::GetTextLineHeight()});
    if (!more.empty() && ImGui::IsItemHovered())
        ImGui::SetTooltip("%s%s", words.c_str(), more.c_str());
}

void LabelPanel::alone(WindowState& desk, LabelNumbers numbers) {
    ImGui::SameLine(0, 0);
    if (ImGui::SmallButton(kAlone))
        showAlone(desk, numbers);
}

/// The popup of one label or a group.
void LabelPanel::look(WindowState& desk) {
    if (std::exchange(opensLook_, false))
        ImGui::OpenPopup("look of labels");
    if (look_.empty() || !ImGui::BeginPopup("look of labels"))
        return;
    ImGui::TextUnformatted(lookName_.c_str());
    const LabelState& state = states_[look_.front()];
    const glm::vec3 now = screenRgb(state.colour);
    float rgb[3] = {now.r, now.g, now.b};
    ImGui::SetNextItemWidth(200);
    const bool coloured = ImGui::ColorPicker3("##colour", rgb);
    if (ImGui::IsItemActivated())
        desk.beginEdit();
    const bool solid = state.look == LabelLook::solid;
    auto opacity = static_cast<float>(state.opacity.value_or(1));
    ImGui::SetNextItemWidth(200);
    const bool faded = ImGui::SliderFloat("opacity", &opacity, 0, 1, solid ? "%.3f per mm" : "%.2f",
                                          solid ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None);
    if (ImGui::IsItemActivated())
        desk.beginEdit();
    desk.trying([&] {
        if (coloured) {
            const glm::dvec3 linear(linearFromSrgb(static_cast<double>(rgb[0])),
                                    linearFromSrgb(static_cast<double>(rgb[1])),
                                    linearFromSrgb(static_cast<double>(rgb[2])));
            desk.setLabels(withColour(*of_, desk.labels(), look_, linear), true);
        }
        if (faded)
            desk.setLabels(
                withOpacity(*of_, desk.labels(), look_, std::clamp(static_cast<double>(opacity), 0.0, 1.0)),
                true);
    });
    if (ImGui::Button("as at first")) {
        editLabels(desk, [&](const LabelList& list, const Labels& labels) {
            return withoutRules(list, labels, look_);
        });
        ImGui::CloseCurrentPopup();
    }
    ImGui::EndPopup();
}

} // namespace tessera
