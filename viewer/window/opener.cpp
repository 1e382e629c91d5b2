// viewer/window/opener.cpp: see opener.h.
#include "viewer/window/opener.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <epoxy/gl.h>
#include <imgui.h>
#include <string>

namespace tessera {
namespace {

constexpr float kThumbnail = 72, kListMargin = 16, kWidest = 620;
constexpr std::size_t kRecentShown = 6;
const ImVec4 kProblemText(1.0f, 0.75f, 0.27f, 1.0f), kFaintText(0.62f, 0.64f, 0.68f, 1.0f);

/// A window in the middle of an area. Returns whether it is to be drawn into; ImGui::End() follows anyway.
bool beginOver(const char* name, const Area& area, float height, bool* open) {
    const auto from = glm::vec2(area.from), size = glm::vec2(area.size);
    const float wide = std::min(kWidest, size.x - 2 * kListMargin),
                high = std::min(height, size.y - 2 * kListMargin);
    ImGui::SetNextWindowPos({from.x + (size.x - wide) / 2, from.y + (size.y - high) / 2}, ImGuiCond_Always);
    ImGui::SetNextWindowSize({wide, high}, ImGuiCond_Always);
    return ImGui::Begin(name, open,
                        ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoResize |
                            ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse);
}

} // namespace

Opener::~Opener() {
    dropTextures();
}

void Opener::dropTextures() {
    for (const Texture& texture : textures_)
        glDeleteTextures(1, &texture.name);
    textures_.clear();
}

const Opener::Texture& Opener::textureOf(const WindowState& desk, std::size_t offer) {
    Texture& texture = textures_[offer];
    const auto thumbnail = texture.name == 0 ? desk.thumbnail(offer) : nullptr;
    if (!thumbnail)
        return texture;
    texture.size = thumbnail->size;
    glGenTextures(1, &texture.name);
    glBindTexture(GL_TEXTURE_2D, texture.name);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, thumbnail->size.x, thumbnail->size.y, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, thumbnail->display.data());
    return texture;
}

void Opener::choices(WindowState& desk, const Area& area) {
    const std::shared_ptr<const VolumeOffers> offers = desk.offers();
    if (of_ != offers) {
        dropTextures();
        textures_.resize(offers ? offers->offers.size() : 0);
        of_ = offers;
    }
    if (!offers)
        return;
    bool open = true;
    const float row = kThumbnail + 2 * ImGui::GetStyle().ItemSpacing.y;
    const float height = 90 + row * static_cast<float>(offers->offers.size());
    if (beginOver("Several volumes: choose one", area, height, &open)) {
        ImGui::TextWrapped("%s", offers->path.filename().string().c_str());
        for (std::size_t n = 0; n < offers->offers.size() && desk.offers() == offers; ++n) {
            const VolumeOffer& offer = offers->offers[n];
            ImGui::PushID(static_cast<int>(n));
            const ImVec2 corner = ImGui::GetCursorScreenPos();
            const bool phases = offer.phases.size() > 1, opens = offer.problem.empty() && !phases;
            // Buttons of phases lie on a row: without the second flag it would take their clicks.
            constexpr auto kUnclicked = ImGuiSelectableFlags_Disabled | ImGuiSelectableFlags_AllowItemOverlap;
            if (ImGui::Selectable("##row", false, opens ? 0 : kUnclicked, {0, kThumbnail}) && opens)
                desk.choose(n);
            ImDrawList& draw = *ImGui::GetWindowDrawList();
            draw.AddRectFilled(corner, {corner.x + kThumbnail, corner.y + kThumbnail},
                               IM_COL32(0, 0, 0, 255));
            if (const Texture& texture = textureOf(desk, n); texture.name != 0) {
                const glm::vec2 from = glm::vec2(corner.x, corner.y) + 0.5f * (kThumbnail - texture.size);
                draw.AddImage(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(texture.name)),
                              {from.x, from.y}, {from.x + texture.size.x, from.y + texture.size.y});
            }
            const ImVec2 after = ImGui::GetCursorScreenPos();
            const float left = corner.x + kThumbnail + 10;
            ImGui::SetCursorScreenPos({left, corner.y + 2});
            ImGui::BeginGroup();
            ImGui::TextUnformatted(offer.title.c_str());
            ImGui::PushStyleColor(ImGuiCol_Text, kFaintText);
            ImGui::TextWrapped("%s", offer.about.c_str());
            ImGui::PopStyleColor();
            if (!offer.problem.empty()) {
                ImGui::PushStyleColor(ImGuiCol_Text, kProblemText);
                ImGui::TextWrapped("%s", offer.problem.c_str());
                ImGui::PopStyleColor();
            }
            for (std::size_t p = 0; phases && p < offer.phases.size(); ++p) {
                const std::string name = std::to_string(p + 1) + ": " + offer.phases[p];
                const float wide = ImGui::CalcTextSize(name.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x;
                if (p > 0) {
                    ImGui::SameLine();
                    if (ImGui::GetContentRegionAvail().x < wide)
                        ImGui::NewLine();
                }
                if (ImGui::SmallButton(name.c_str()))
                    desk.choose(n, static_cast<int>(p) + 1);
            }
            ImGui::EndGroup();
            const float below =
                std::max(after.y, ImGui::GetItemRectMax().y + ImGui::GetStyle().ItemSpacing.y);
            ImGui::SetCursorScreenPos({after.x, below});
            ImGui::PopID();
        }
        if (!offers->passedOver.empty()) {
            ImGui::PushStyleColor(ImGuiCol_Text, kFaintText);
            ImGui::TextWrapped("passed over: %s", offers->passedOver.c_str());
            ImGui::PopStyleColor();
        }
    }
    ImGui::End();
    if (!open)
        desk.dismissOffers();
}

void Opener::goTo(WindowState& desk, const std::filesystem::path& folder) {
    listing_ = listFolder(folder);
    desk.settings().folder = listing_->folder;
}

void Opener::recent(WindowState& desk) {
    const auto& all = desk.settings().recent;
    if (all.empty())
        return;
    ImGui::TextDisabled("opened last");
    for (std::size_t n = 0; n < std::min(all.size(), kRecentShown); ++n) {
        ImGui::PushID(static_cast<int>(n));
        const std::filesystem::path path = all[n];
        if (ImGui::Selectable((path.filename().string() + "##recent").c_str())) {
            desk.open(path);
            ImGui::PopID();
            return;
        }
        if (ImGui::IsItemHovered())
            ImGui::SetTooltip("%s", path.string().c_str());
        ImGui::PopID();
    }
    ImGui::Separator();
}

void Opener::entries(WindowState& desk) {
    const FolderListing listing = *listing_; // a copy, because a click replaces it
    ImGui::TextWrapped("%s", listing.folder.string().c_str());
    if (ImGui::Button("up"))
        goTo(desk, folderAt(listing.folder.parent_path()));
    ImGui::SameLine();
    if (const char* const home = std::getenv("HOME"); home && ImGui::Button("home"))
        goTo(desk, folderAt(home));
    ImGui::SameLine();
    const std::string whole = listing.otherFiles == 0
                                  ? std::string("open this folder")
                                  : "open this folder (" + std::to_string(listing.otherFiles) +
                                        (listing.otherFiles == 1 ? " file)" : " files)");
    if (ImGui::Button(whole.c_str()))
        desk.open(listing.folder);
    if (!listing.problem.empty())
        ImGui::TextColored(kProblemText, "%s", listing.problem.c_str());
    ImGui::BeginChild("entries", {0, 0}, true);
    constexpr const char* kKinds[] = {"/", "  (store)", ""};
    for (std::size_t n = 0; n < listing.entries.size(); ++n) {
        const FolderEntry& entry = listing.entries[n];
        ImGui::PushID(static_cast<int>(n));
        if (ImGui::Selectable((entry.name + kKinds[static_cast<int>(entry.kind)] + "##entry").c_str())) {
            if (entry.kind == FolderEntry::Kind::folder)
                goTo(desk, entry.path);
            else
                desk.open(entry.path);
        }
        ImGui::PopID();
    }
    if (listing.entries.empty())
        ImGui::TextDisabled("no folders, stores, scenes or NIfTI files");
    ImGui::EndChild();
}

void Opener::browser(WindowState& desk, const Area& area) {
    const ViewingState::Kind kind = desk.state().kind;
    const bool nothing = (kind == ViewingState::Kind::nothing || kind == ViewingState::Kind::failed);
    if ((!nothing && !desk.showBrowser) || kind == ViewingState::Kind::opening || desk.offers()) {
        listing_.reset(); // read again when it is shown next
        return;
    }
    if (!listing_)
        goTo(desk,
             folderAt(desk.settings().folder.empty() ? std::filesystem::path(".") : desk.settings().folder));
    bool open = true;
    Area below = area; // below the message of a failed opening
    if (nothing) {
        below.from.y += 0.3 * area.size.y;
        below.size.y *= 0.7;
    }
    if (beginOver("Open", below, 460, nothing ? nullptr : &open)) {
        recent(desk);
        entries(desk);
    }
    ImGui::End();
    if (!open)
        desk.showBrowser = false;
}

void Opener::draw(WindowState& desk, const Area& area) {
    if (area.size.x < 4 * kListMargin || area.size.y < 4 * kListMargin)
        return;
    choices(desk, area);
    browser(desk, area);
}

} // namespace tessera
