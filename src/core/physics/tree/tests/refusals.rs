//! What is refused, and how.

use nalgebra::Vector3;

use super::examples::{PIN, UNIVERSAL, rods};
use crate::physics::Body;
use crate::physics::support::{Pivot, PivotAxes, Support};
use crate::physics::tree::{JointKind, Tree, TreeError};

#[test]
fn wrong_trees_are_refused_by_name() {
    assert_eq!(Tree::new(&[]), Err(TreeError::Empty));
    let good = rods(3, JointKind::Free, UNIVERSAL);
    assert!(Tree::new(&good).is_ok());
    let refused = |change: &dyn Fn(&mut Vec<crate::physics::tree::Link>)| {
        let mut links = good.clone();
        change(&mut links);
        Tree::new(&links).unwrap_err()
    };
    assert_eq!(
        refused(&|links| links[1].parent = Some(2)),
        TreeError::Order { link: 1, parent: 2 }
    );
    assert_eq!(
        refused(&|links| links[2].parent = Some(2)),
        TreeError::Order { link: 2, parent: 2 }
    );
    assert_eq!(
        refused(&|links| links[2].parent = None),
        TreeError::Free { link: 2 }
    );
    assert_eq!(
        refused(&|links| links[1].joint.kind = JointKind::Free),
        TreeError::Free { link: 1 }
    );
    let no_axis = JointKind::Pin {
        axis: Vector3::zeros(),
    };
    assert_eq!(
        refused(&|links| links[1].joint.kind = no_axis),
        TreeError::Axis { link: 1, axis: 0 }
    );
    let parallel = JointKind::Universal {
        axes: [Vector3::x(), Vector3::x() * -2.0],
    };
    assert_eq!(
        refused(&|links| links[2].joint.kind = parallel),
        TreeError::ParallelAxes { link: 2 }
    );
    let infinite = refused(&|links| links[2].body = Body::IMMOVABLE);
    assert!(matches!(infinite, TreeError::Mass { link: 2, .. }));
    let pivot = Support::Pivot(Pivot {
        at_m: Vector3::zeros(),
        axes: PivotAxes::All,
        damping_n_m_s: 0.0,
    });
    assert_eq!(
        refused(&|links| links[1].body = links[1].body.with_support(Some(pivot))),
        TreeError::Support { link: 1 }
    );
    assert_eq!(
        refused(&|links| links[0].joint.damping_n_m_s = 1.0),
        TreeError::Passive { link: 0 }
    );
    assert_eq!(
        refused(&|links| links[1].joint.stiffness_n_m = -1.0),
        TreeError::Passive { link: 1 }
    );
    let far = crate::math::Pose::translation(f64::NAN, 0.0, 0.0);
    assert_eq!(
        refused(&|links| links[1].joint.link_from_joint = far),
        TreeError::Pose { link: 1 }
    );
}

#[test]
fn angles_beyond_their_limits_are_found() {
    let mut links = rods(2, PIN, UNIVERSAL);
    links[1].joint.limits_rad[1] = [-0.5, 0.5];
    let tree = Tree::new(&links).unwrap();
    let mut state = tree.at_rest();
    assert_eq!(tree.beyond_limits(&state), None);
    state.coordinates[2] = 0.6;
    assert_eq!(tree.beyond_limits(&state), Some(2));
    state.coordinates[2] = f64::NAN;
    assert_eq!(tree.beyond_limits(&state), Some(2));
}
