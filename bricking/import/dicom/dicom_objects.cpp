// bricking/import/dicom/dicom_objects.cpp: see dicom_objects.h. The numbers are those of DICOM PS3.4, table
// B.5-1.
#include "bricking/import/dicom/dicom_objects.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace tessera {
namespace {

const std::string kRoot = "1.2.840.10008.5.1.4.1.1.";

constexpr std::array kSliceClasses = {"2", "2.1", "2.2", "4", "4.1", "4.4", "128", "130", "13.1.1", "128.1"};

// Defined terms of Modality (0008,0060), DICOM PS3.3, C.7.3.1.1.1, retired ones too.
constexpr std::array kModalities = {
    "ANN", "AR",     "ASMT",    "AU",         "BDUS",   "BI",    "BMD",      "CD",         "CFM",      "CP",
    "CR",  "CS",     "CT",      "CTPROTOCOL", "DD",     "DF",    "DG",       "DM",         "DMS",      "DOC",
    "DS",  "DX",     "EC",      "ECG",        "EEG",    "EMG",   "EOG",      "EPS",        "ES",       "FA",
    "FID", "FS",     "GM",      "HC",         "HD",     "IO",    "IOL",      "IVOCT",      "IVUS",     "KER",
    "KO",  "LEN",    "LP",      "LS",         "M3D",    "MA",    "MG",       "MR",         "MS",       "NM",
    "OAM", "OCT",    "OP",      "OPM",        "OPR",    "OPT",   "OPTBSV",   "OPTENF",     "OPV",      "OSS",
    "OT",  "PA",     "PLAN",    "POS",        "PR",     "PT",    "PX",       "REG",        "RESP",     "RF",
    "RG",  "RTDOSE", "RTIMAGE", "RTINTENT",   "RTPLAN", "RTRAD", "RTRECORD", "RTSEGANN",   "RTSTRUCT", "RWV",
    "SEG", "SM",     "SMR",     "SR",         "SRF",    "ST",    "STAIN",    "TEXTUREMAP", "TG",       "US",
    "VA",  "VF",     "XA",      "XAPROTOCOL", "XC"};

struct Words {
    const char* begins; // after kRoot; a whole number or parts of it, separated by points
    const char* words;
};
// The longer beginnings come first.
constexpr std::array kWords = {Words{"88.67", "dose report"},
                               Words{"88.68", "dose report"},
                               Words{"88.73", "dose report"},
                               Words{"88.74", "dose report"},
                               Words{"88.59", "key object selection"},
                               Words{"88", "structured report"},
                               Words{"104.1", "PDF document"},
                               Words{"104", "document"},
                               Words{"11", "presentation state"},
                               Words{"66.4", "segmentation"},
                               Words{"66.5", "surface segmentation"},
                               Words{"66", "raw data"},
                               Words{"67", "real-world value mapping"},
                               Words{"481.1", "radiotherapy image"},
                               Words{"481.2", "radiotherapy dose"},
                               Words{"481.3", "radiotherapy structure set"},
                               Words{"481", "radiotherapy object"},
                               Words{"7", "secondary capture"},
                               Words{"9", "waveform"},
                               Words{"12", "X-ray angiogram"},
                               Words{"1.1", "digital radiograph"},
                               Words{"1.2", "mammogram"},
                               Words{"1", "radiograph"},
                               Words{"3", "ultrasound"},
                               Words{"6", "ultrasound"},
                               Words{"20", "nuclear medicine image"},
                               Words{"77", "photograph or video"}};

bool beginsWithParts(const std::string& uid, const std::string& parts) {
    return uid.rfind(parts, 0) == 0 && (uid.size() == parts.size() || uid[parts.size()] == '.');
}

} // namespace

bool isSliceClass(const std::string& storageClass) {
    return std::any_of(kSliceClasses.begin(), kSliceClasses.end(),
                       [&](const char* item) { return storageClass == kRoot + item; });
}

std::string modalityOf(const std::string& text) {
    const bool known =
        std::any_of(kModalities.begin(), kModalities.end(), [&](const char* item) { return text == item; });
    return known ? text : "";
}

std::string objectWords(const std::string& storageClass) {
    if (storageClass == "1.2.840.10008.1.3.10")
        return "DICOMDIR";
    if (isSliceClass(storageClass))
        return "";
    const auto at = std::find_if(kWords.begin(), kWords.end(), [&](const Words& row) {
        return beginsWithParts(storageClass, kRoot + row.begins);
    });
    return at == kWords.end() ? "" : at->words;
}

bool hasType(const std::string& imageType, const std::string& word) {
    std::string plain = "\\"; // in capitals, without the blanks that some writers put around each value
    for (const char c : imageType)
        if (c != ' ')
            plain += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return (plain + "\\").find("\\" + word + "\\") != std::string::npos;
}

std::string derivationOf(const std::string& imageType) {
    for (const char* word : {"MPR", "CPR", "REFORMATTED", "MIP", "MINIP", "MIN_IP", "AVERAGE", "SUBTRACTION"})
        if (hasType(imageType, word))
            return word;
    return "";
}

} // namespace tessera
