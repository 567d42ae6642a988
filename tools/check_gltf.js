// Khronos' validator on one file: fails on errors and warnings.
const fs = require("fs");
const validator = require("gltf-validator");

const file = process.argv[2];
validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { maxIssues: 0 }).then((report) => {
    const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
    const { animationCount, materialCount, totalTriangleCount } = report.info;
    console.log(
        `validator ${report.validatorVersion}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos, ` +
            `${numHints} hints; ${animationCount} animation, ${materialCount} materials, ${totalTriangleCount} triangles`,
    );
    for (const message of messages.slice(0, 5)) console.log(`  ${message.code} ${message.pointer}`);
    process.exit(numErrors + numWarnings === 0 ? 0 : 1);
});
