//! Two bodies that are one from an event on.

use crate::config::scene_from_toml;
use crate::motion::LinkIndex;

const TWO: &str = "name = \"x\"\n[timing]\nstamps = \"physical\"\n\
     [[body]]\nname = \"block\"\nshape = { kind = \"cuboid\", size_mm = [90, 80, 70] }\nmass_g = 80\n\
     [[body]]\nname = \"arrow\"\nshape = { kind = \"cylinder\", length_mm = 700, radius_mm = 4 }\nmass_g = 25\n\
     [[surface]]\nname = \"floor\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
     [[event]]\nname = \"hit\"\nkind = \"change\"\nbody = \"arrow\"\n\
     [[event]]\nname = \"end\"\nkind = \"end\"\n\
     [[joint]]\nname = \"stuck\"\nkind = \"fixed\"\nparent = \"block\"\nchild = \"arrow\"\nfrom = \"hit\"\n";

#[test]
fn either_may_be_the_parent_and_both_are_concerned() {
    let turned = TWO.replace("body = \"arrow\"", "body = \"block\"").replace(
        "parent = \"block\"\nchild = \"arrow\"",
        "parent = \"arrow\"\nchild = \"block\"",
    );
    for text in [TWO, &turned] {
        let scene = scene_from_toml(text).unwrap();
        let pair = scene.stuck_at(0).unwrap();
        assert_eq!(pair.links, [0, 1].map(LinkIndex));
        assert_eq!(scene.links_at(0).len(), 2);
        assert!(scene.mechanisms.keys().all(|of| scene.concerns(0, of)));
        assert!(scene.are_joined(LinkIndex(0), LinkIndex(1)));
        assert!(scene.tied_at(1).is_some());
    }
}

#[test]
fn what_is_not_computed_is_refused() {
    let lands = "[[event]]\nname = \"lands\"\nkind = \"collision\"\nbody = \"block\"\nsurface = \"floor\"\nrestitution = 0.3\n";
    let cases = [
        (TWO.to_owned() + "until = \"end\"\n", "expected no until"),
        (
            TWO.to_owned() + "child_at_mm = [0, 0, 350]\n",
            "expected no child_at_mm",
        ),
        (
            TWO.replace(
                "[[event]]\nname = \"end\"",
                &format!("{lands}[[event]]\nname = \"end\""),
            ),
            "what hits them then is not computed",
        ),
        (
            TWO.replace("mass_g = 25\n", "mass_g = 25\nforce_m_s2 = [0, 0, 1]\n"),
            "neither drag nor force_m_s2",
        ),
        (
            TWO.replace(
                "shape = { kind = \"cuboid\", size_mm = [90, 80, 70] }\n",
                "shape = { kind = \"sphere\", radius_mm = 40 }\nlift = 0.01\n",
            ),
            "nor lift",
        ),
        (
            TWO.replace("mass_g = 80\n", "mass_g = 80\ndrag_quadratic_per_m = 0.1\n"),
            "drag",
        ),
        (
            TWO.replace("\"physical\"", "\"tempo\""),
            "expected stamps = \"physical\"",
        ),
        (
            TWO.replace("body = \"arrow\"\n[[event]]", "body = \"block\"\n[[event]]"),
            "kind = \"change\" and body = \"arrow\"",
        ),
        (TWO.replace("\"fixed\"", "\"ball\""), "kind = \"fixed\""),
        (
            TWO.replacen(
                "[[event]]",
                "[[event]]\nname = \"go\"\nkind = \"start\"\n[[event]]",
                1,
            ) + "[[phase]]\nname = \"held\"\nmotion = \"held\"\nbody = \"arrow\"\nfrom = \"go\"\nuntil = \"hit\"\n",
            "expected no other phase",
        ),
        (
            TWO.to_owned() + "[[free]]\nquantity = \"arrow.mass\"\n",
            "phase",
        ),
    ];
    for (text, expected) in cases {
        let error = scene_from_toml(&text).expect_err(expected).to_string();
        assert!(error.contains(expected), "{error}: expected {expected}");
    }
}
