// viewer/cli/options/scene_options.h: options that change the scene: those that each set a key, and those of
// a picture's mode.
#pragma once

#include "core/base/error.h"
#include "core/scene/scene.h"
#include "viewer/cli/options/command.h"

#include <algorithm>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

// Options that each set a key of the scene, and `--set`, which sets any. Names, help, allowed values and
// refusals come from the table of keys (core/scene/*_fields.cpp).

/// Adds `--set KEY=VALUE`, which may be repeated.
/// @param of  "the scene", for help
/// @param more  further words of help: "; overrides other options"
Option addSetOption(Command& command, std::vector<std::string>& sets, const std::string& of,
                    const std::string& more = {});
/// Sets the keys in the order given. Throws InputError naming `--set` and the key.
void applySets(const std::vector<std::string>& sets, Scene& scene);

/// The key of scenes that a name means: a key ("camera.view", "volumes[1].opacity"), or an option that sets
/// one, with or without its hyphens ("--step", "view"); the word itself of options that set several
/// ("preset"). "": there is none.
std::string keyNamed(const std::string& name);
/// For the end of a message: '; nearest: "shading.ambient"' by the whole of a key or its last part, or the
/// key to use in place of an option. "": nothing is near.
std::string keyHint(const std::string& name);
/// Sets a key as its option or `--set` does. A side of the patient takes the place of a camera by position.
/// Throws InputError naming `where`.
void setKeyFromText(Scene& scene, const std::string& key, const std::string& text, const std::string& where);

class KeyOptions {
  public:
    /// A word in the help of options that the table of keys cannot know: "{single-ray engines}". Give it
    /// before the options.
    void word(const std::string& mark, const std::string& text) { words_[mark] = text; }
    /// Adds the options of keys in this order: of "quality.seed", or of all keys of "quality". Those that
    /// were added before are left out.
    void add(Command& command, const std::vector<std::string>& keys);
    /// Adds those of all keys that were not added before.
    void addOthers(Command& command) { addOf(command, {}); }
    /// As a further `--set`.
    void alsoSet(const std::string& set) { sets_.push_back(set); }
    /// Adds `--set`.
    Option set(Command& command) {
        return addSetOption(command, sets_, "the scene", "; overrides other options");
    }

    /// The value of an option as given; "" if it was not.
    std::string textOf(const std::string& option) const;
    /// True if --same-frame was given: apply() has called takeAnyFrame() then.
    bool takesAnyFrame() const;
    /// Refuses --same-frame for a scene without labels and meshes of files.
    void checkFrames(const Scene& scene) const;
    /// True if an option or `--set` sets the key, or an object that holds it.
    bool says(const std::string& key) const;
    /// Applies the options. Throws InputError naming the option.
    void apply(Scene& scene) const;
    /// Applies `--set`.
    void applySets(Scene& scene) const { tessera::applySets(sets_, scene); }

  private:
    struct Row {
        std::string option, key;
        bool isNumber = false;
        bool flagMeans = false; // the key's value where the flag is given
        std::string text = {};  // as given; "": not given
        bool flag = false;
    };
    void addOf(Command& command, const std::string& key);

    std::list<Row> rows_; // a list, because the parser keeps pointers to its items
    std::map<std::string, std::string> words_;
    std::vector<std::string> sets_;
};

/// What --same-frame means: labels of all volumes, and structure sets, are taken in any frame of reference.
void takeAnyFrame(Scene& scene);

// Options of slices and cuts, and which options have an effect in which mode.

struct ModeOptions {
    std::string slice, slab; // "": the scene's
    std::vector<std::string> boxes, boxesInVoxels, planes;
    std::string keep;
    int cutVolume = -1; // that alone is cut; -1: all are

    static constexpr const char* kBody = "body"; // "body": a box found in the volume
    bool cropsToBody() const { return std::find(boxes.begin(), boxes.end(), kBody) != boxes.end(); }
};
/// A box in text, with its bounds checked. Throws InputError naming option.
/// @param forms  what is expected: kBoxForm, or kCropForms where "body" is another way to say one
constexpr char kBoxForm[] = "X0,X1,Y0,Y1,Z0,Z1", kCropForms[] = "body or X0,X1,Y0,Y1,Z0,Z1";
CropBox cropBoxOf(const std::string& text, const std::string& option, CropBox::Space space,
                  const char* forms = kBoxForm);

void addModeOptions(Command& command, ModeOptions& options);
/// The cuts that options add to: the scene's, or those of --cut-volume. Throws InputError where the scene has
/// no such volume.
Cuts& cutsOf(const ModeOptions& options, Scene& scene);
/// Options override the scene; `--crop body` is left to cropToBody()
/// (viewer/cli/render/scene_from_arguments.h). Throws InputError naming the option.
/// @param keys  applied to the scene before
void applyModeOptions(const ModeOptions& options, const KeyOptions& keys, Scene& scene);
/// Names an option of slices and of single values (--slab, --window, --value-colour) that has no effect in
/// the scene's mode. None: there is none.
std::optional<InputError> refusalByMode(const ModeOptions& options, const KeyOptions& keys,
                                        const Scene& scene);

} // namespace tessera
