n=16; 
pts=[for(t=[0:n-1]) for(k=[[10,0],[10,.35],[12.5,.5],[12.5,.8]]) let(a=360*(t+k[1])/n) [k[0]*cos(a),k[0]*sin(a)]];
difference(){ union(){ linear_extrude(6,twist=20,slices=12) polygon(pts); translate([0,0,6]) rotate(-20) linear_extrude(6,twist=-20,slices=12) polygon(pts);} translate([0,0,-1]) cylinder(r=3,h=20,$fn=50);}
