// A revolved profile with fillets.
bead=[for(a=[-90:4.5:90]) [20+5*cos(a),5+5*sin(a)]];
neck=[for(a=[270:-3:180]) [13+8*cos(a),18+8*sin(a)]];
rotate_extrude() polygon(concat([[0,0]],bead,neck,[[5,30],[0,30]]));
